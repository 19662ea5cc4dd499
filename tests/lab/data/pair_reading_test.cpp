#include "lab/data/pair_reading.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/errors.h"
#include "diffsac/core/parallel.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
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
      CHECK(part.problem.points.rows() == (whole.problem.match_ratio.array() <= 0.5).count());
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

}  // namespace diffsac
