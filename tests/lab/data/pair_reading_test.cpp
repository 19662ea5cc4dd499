#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "core/errors.h"
#include "diffsac/core/parallel.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/pair_filter.h"
#include "lab/data/pair_reading.h"
#include "lab/data/pair_scenes.h"
#include "lab/data/two_view_test_util.h"

namespace diffsac {
namespace {

std::unique_ptr<Dataset> Make(const std::string& yaml) { return MakeDataset(ConfigFromYaml(yaml, "test.yaml"), 1); }

}  // namespace

TEST_CASE("pairs are read once for all who hold the reading of a scene") {
  const TemporaryFolder folder;
  WriteCorrespondences(folder / "s", SyntheticSet(3, 40, Rng(1)));
  const SceneFolder scene{"s", folder / "s"};
  const auto reading = PairReading::Open(scene, {});
  CHECK(PairReading::Open({"s", folder / "s/"}, {}) == reading);
  CHECK(PairReading::Open(scene, {false, 2.0, 0.0}) != reading);
  CHECK(PairReading::Open(scene, {true, 0.0, 0.0}) != reading);
  CHECK(PairReading::Open({"t", folder / "s"}, {}) != reading);
  const auto pair = reading->Pair(1);
  CHECK(pair->id == "s/im_001-im_002");
  CHECK(pair->scene == "s");
  CHECK(reading->Where(1) == folder / "s/matches.h5: im_001-im_002");
  std::vector<const Example*> seen(32);
  ParallelFor(32, 4, [&](std::int64_t i) { seen[i] = PairReading::Open(scene, {})->Pair(i % 3).get(); });
  for (int i = 0; i < 32; ++i) CHECK(seen[i] == reading->Pair(i % 3).get());
}

TEST_CASE("files that were written anew are read anew") {
  const TemporaryFolder folder;
  const SceneFolder scene{"s", folder / "s"};
  WriteCorrespondences(scene.folder, SyntheticSet(2, 20, Rng(1)));
  const auto before = PairReading::Open(scene, {});
  WriteCorrespondences(scene.folder, SyntheticSet(2, 30, Rng(2)));
  std::filesystem::last_write_time(folder / "s/matches.h5",
                                   std::filesystem::last_write_time(folder / "s/matches.h5") + std::chrono::seconds(1));
  CHECK(PairReading::Open(scene, {})->Pair(0)->problem.points.rows() == 30);
}

TEST_CASE("datasets that differ by a filter do not read again what another one has read") {
  const TemporaryFolder folder;
  const auto write = [&] { WriteCorrespondences(folder / "kitti_00_step_01", SyntheticSet(3, 40, Rng(1))); };
  const std::string root = "\"" + folder.path() + "\"";
  const std::string kinds[][2] = {{"{type: correspondences, refine_truth_px: 2, paths: [" + root + "]", "max_ratio"},
                                  {"{type: kitti, refine_truth_px: 2, root: " + root, "snn_threshold"}};
  for (const auto& [start, ratio] : kinds) {
    write();
    auto all = Make(start + "}");
    for (int i = 0; i < 3; ++i) all->Get(i);
    // Nothing can be read any more.
    WriteRaw(folder / "kitti_00_step_01/match_conf.h5", "no HDF5");
    auto half = Make(start + ", " + ratio + ": 0.5}");
    REQUIRE(half->size() == 3);
    for (int i = 0; i < 3; ++i) {
      const Example whole = all->Get(i), part = half->Get(i);
      CHECK(part.problem.points.rows() == (whole.problem.snn_ratio.array() <= 0.5).count());
      CHECK(part.truth.model == whole.truth.model);
      CHECK(part.truth.inliers.size() == static_cast<std::size_t>(part.problem.points.rows()));
    }
    // Without them it is read again.
    all.reset();
    half.reset();
    CHECK_THROWS_AS(Make(start + "}")->Get(0), Error);
  }
}

TEST_CASE("when the datasets go, what they have read goes") {
  const TemporaryFolder folder;
  WriteCorrespondences(folder / "s", SyntheticSet(2, 40, Rng(1)));
  std::weak_ptr<const Example> pair;
  {
    const auto reading = PairReading::Open({"s", folder / "s"}, {});
    pair = reading->Pair(0);
    CHECK(!pair.expired());
  }
  CHECK(pair.expired());
}

TEST_CASE("a folder is a scene, or the folders in it are") {
  const TemporaryFolder folder;
  for (const char* name : {"root/b", "root/a"}) WriteCorrespondences(folder / name, SyntheticSet(1, 4, Rng(1)));
  const auto scenes = FindScenes(folder / "root");
  REQUIRE(scenes.size() == 2);
  CHECK(scenes[0].name == "a");
  CHECK(scenes[1].folder == folder / "root/b");
  REQUIRE(FindScenes(folder / "root/b/").size() == 1);
  CHECK(FindScenes(folder / "root/b/")[0].name == "b");
  CHECK(Has(ErrorOf([&] { FindScenes(folder / "nowhere"); }), "no such folder"));
  const TemporaryFolder empty;
  CHECK(Has(ErrorOf([&] { FindScenes(empty.path()); }), "matches.h5"));
}

TEST_CASE("positions are spread evenly") {
  using Positions = std::vector<std::int64_t>;
  CHECK(EvenlySpread(3, 0) == Positions{0, 1, 2});
  CHECK(EvenlySpread(3, 5) == Positions{0, 1, 2});
  CHECK(EvenlySpread(10, 4) == Positions{0, 2, 5, 7});
  CHECK(EvenlySpread(0, 4).empty());
}

namespace {

Example OnePair() {
  Example pair = SyntheticSet(1, 60, Rng(3)).pairs.front();
  pair.id = "scene/" + pair.id;
  return pair;
}

PairFilter Capped(PointCap cap) {
  PairFilter filter;
  filter.max_points = 10;
  filter.cap = cap;
  return filter;
}

}  // namespace

TEST_CASE("without a filter a pair stays what it is") {
  const Example pair = OnePair(), same = Filtered(pair, {});
  CHECK(same.id == pair.id);
  CHECK(same.image2 == pair.image2);
  CHECK(same.problem.points == pair.problem.points);
  CHECK(same.problem.snn_ratio == pair.problem.snn_ratio);
  CHECK(same.problem.scale_rotation_changes == pair.problem.scale_rotation_changes);
  CHECK(same.problem.descriptors == pair.problem.descriptors);
  CHECK(same.truth.assignment == pair.truth.assignment);
}

TEST_CASE("matches are filtered by ratio and number, in their order") {
  const Example pair = OnePair();
  PairFilter filter;
  filter.max_ratio = 0.8;
  const Example filtered = Filtered(pair, filter);
  CHECK(filtered.problem.points.rows() == (pair.problem.snn_ratio.array() <= 0.8).count());
  CHECK((filtered.problem.snn_ratio.array() <= 0.8).all());
  const Example best = Filtered(pair, Capped(PointCap::kBest));
  REQUIRE(best.problem.points.rows() == 10);
  Eigen::VectorXd sorted = pair.problem.snn_ratio;
  std::sort(sorted.begin(), sorted.end());
  CHECK(best.problem.snn_ratio.maxCoeff() <= sorted[9]);
}

TEST_CASE("ratios that are not to be known neither filter nor order, and are gone") {
  const Example pair = OnePair();
  PairFilter filter;
  filter.ratios = false;
  filter.max_ratio = 0.8;
  const Example unrated = Filtered(pair, filter);
  CHECK(unrated.problem.snn_ratio.size() == 0);
  CHECK(unrated.problem.points == pair.problem.points);
  CHECK(unrated.problem.descriptors == pair.problem.descriptors);
  CHECK(unrated.truth.assignment == pair.truth.assignment);
  PairFilter capped = Capped(PointCap::kBest);
  CHECK(KeptRows(pair, capped) != std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  capped.ratios = false;
  CHECK(KeptRows(pair, capped) == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
}

TEST_CASE("similarities that are not to be known are gone") {
  Example pair = OnePair();
  pair.problem.scale_rotation_changes = PointMatrix::Random(pair.problem.points.rows(), 2);
  PairFilter filter;
  CHECK(Filtered(pair, filter).problem.scale_rotation_changes == pair.problem.scale_rotation_changes);
  filter.scale_rotation_changes = false;
  CHECK(Filtered(pair, filter).problem.scale_rotation_changes.size() == 0);
  CHECK(Filtered(pair, filter).problem.snn_ratio == pair.problem.snn_ratio);
}

TEST_CASE("what belongs to a match goes with it") {
  const Example pair = OnePair();
  PairFilter filter = Capped(PointCap::kRandom);
  filter.shuffle_points = true;
  const std::vector<int> rows = KeptRows(pair, filter);
  const Example filtered = Filtered(pair, filter);
  REQUIRE(rows.size() == 10);
  CHECK(!std::is_sorted(rows.begin(), rows.end()));
  for (int i = 0; i < 10; ++i) {
    CHECK(filtered.problem.points.row(i) == pair.problem.points.row(rows[i]));
    CHECK(filtered.problem.snn_ratio[i] == pair.problem.snn_ratio[rows[i]]);
    CHECK(filtered.problem.scale_rotation_changes.row(i) == pair.problem.scale_rotation_changes.row(rows[i]));
    CHECK(filtered.problem.descriptors.row(i) == pair.problem.descriptors.row(rows[i]));
    CHECK(filtered.truth.assignment[i] == pair.truth.assignment[rows[i]]);
  }
  CHECK(KeptRows(pair, filter) == rows);
}

TEST_CASE("what is not known of the matches stays empty") {
  Example pair = OnePair();
  pair.problem.snn_ratio.resize(0);
  pair.problem.scale_rotation_changes.resize(0, 0);
  pair.problem.descriptors.resize(0, 0);
  pair.truth.assignment.clear();
  const Example first = Filtered(pair, Capped(PointCap::kBest));
  CHECK(first.problem.points == pair.problem.points.topRows(10));
  CHECK(first.problem.snn_ratio.size() == 0);
  CHECK(first.problem.scale_rotation_changes.size() == 0);
  CHECK(first.problem.descriptors.size() == 0);
  CHECK(first.truth.assignment.empty());
}

TEST_CASE("noise of descriptors is as strong as asked for, for each image, and the same whenever a pair is read") {
  Example pair = OnePair();
  pair.problem.descriptors.resize(pair.problem.points.rows(), 256);
  pair.problem.descriptors.leftCols(128).setConstant(2.0f);
  pair.problem.descriptors.rightCols(128).setConstant(10.0f);
  PairFilter filter;
  filter.descriptor_noise = 0.5;
  const DescriptorMatrix noisy = Filtered(pair, filter).problem.descriptors;
  const DescriptorMatrix noise = noisy - pair.problem.descriptors;
  const double values = static_cast<double>(noise.size()) / 2.0;
  CHECK(noise.leftCols(128).norm() / std::sqrt(values) == Approx(1.0).epsilon(0.05));
  CHECK(noise.rightCols(128).norm() / std::sqrt(values) == Approx(5.0).epsilon(0.05));
  CHECK(Filtered(pair, filter).problem.descriptors == noisy);
}

}  // namespace diffsac
