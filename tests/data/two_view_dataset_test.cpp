#include "diffsac/data/two_view_dataset.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "data/data_test_util.h"
#include "data/two_view_test_util.h"
#include "diffsac/data/dataset_factory.h"

namespace diffsac {
namespace {

TwoViewExample OnePair() {
  TwoViewExample pair = SyntheticSet(1, 60, Rng(3)).pairs.front();
  pair.scene = "scene";
  CompleteTruth(pair.problem, &pair.truth);
  return pair;
}

TEST_CASE("A pair becomes an example of each task, with the truth that is known") {
  const TwoViewExample pair = OnePair();
  const Example f = ToExample(pair, Task::kFundamental, {});
  CHECK(f.id == "scene/" + pair.id);
  CHECK(f.scene == "scene");
  CHECK(f.problem.points == pair.problem.points);
  CHECK(f.problem.quality == pair.problem.quality);
  CHECK(f.problem.cameras->K1 == pair.problem.K1);
  const Example h = ToExample(pair, Task::kHomography, {});
  CHECK(h.truth.model.size() == 0);
}

TEST_CASE("Matches are filtered by ratio and number, in their order") {
  const TwoViewExample pair = OnePair();
  CorrespondencesOptions options;
  options.max_ratio = 0.8;
  const Example filtered = ToExample(pair, Task::kFundamental, options);
  CHECK(filtered.problem.points.rows() == (pair.problem.quality.array() <= 0.8).count());
  CHECK((filtered.problem.quality.array() <= 0.8).all());
  options.max_ratio = 1.0;
  options.max_points = 10;
  const Example best = ToExample(pair, Task::kFundamental, options);
  REQUIRE(best.problem.points.rows() == 10);
  Eigen::VectorXd sorted = pair.problem.quality;
  std::sort(sorted.begin(), sorted.end());
  CHECK(best.problem.quality.maxCoeff() <= sorted[9]);
}

TEST_CASE("Noise of descriptors is as strong as asked for, for each image, and the same whenever a pair is read") {
  TwoViewExample pair = OnePair();
  pair.problem.descriptors.resize(pair.problem.points.rows(), 256);
  pair.problem.descriptors.leftCols(128).setConstant(2.0f);
  pair.problem.descriptors.rightCols(128).setConstant(10.0f);
  CorrespondencesOptions options;
  options.descriptor_noise = 0.5;
  const DescriptorMatrix noisy = ToExample(pair, Task::kFundamental, options).problem.descriptors;
  const DescriptorMatrix noise = noisy - pair.problem.descriptors;
  const double values = static_cast<double>(noise.size()) / 2.0;
  CHECK(noise.leftCols(128).norm() / std::sqrt(values) == Approx(1.0).epsilon(0.05));
  CHECK(noise.rightCols(128).norm() / std::sqrt(values) == Approx(5.0).epsilon(0.05));
  CHECK(ToExample(pair, Task::kFundamental, options).problem.descriptors == noisy);
}

TEST_CASE("Scenes of a folder are read through the factory; what is missing is named") {
  const TemporaryFolder folder;
  WriteCorrespondences(folder / "a", SyntheticSet(3, 40, Rng(1)));
  WriteCorrespondences(folder / "b", SyntheticSet(4, 40, Rng(2)));
  const auto make = [&](const std::string& more) {
    return MakeDataset(
        Config::FromString("type: correspondences\npaths: [\"" + folder.path() + "\"]\n" + more, "test.yaml"), 1);
  };
  const auto dataset = make("task: essential\n");
  CHECK(dataset->task() == Task::kEssential);
  REQUIRE(dataset->size() == 7);
  CHECK(dataset->Get(0).scene == "a");
  CHECK(dataset->Get(6).scene == "b");
  CHECK(dataset->Get(6).index == 6);
  CHECK(dataset->Get(0).truth.pose->translation.norm() == Approx(1.0));
  CHECK(make("max_pairs: 2\n")->size() == 4);
  // Of three and four pairs the first half and the second, rounded, are all.
  const auto first = make("part: [0, 0.5]\n"), second = make("part: [0.5, 1]\n");
  CHECK(first->size() == 4);
  CHECK(second->size() == 3);
  CHECK(first->Get(0).id == dataset->Get(0).id);
  CHECK(second->Get(2).id == dataset->Get(6).id);
  CHECK(dataset->Get(0).problem.descriptors.size() == 0);
  CHECK(dataset->Get(0).problem.size2 == ImageSize{600, 400});
  // Descriptors go with their matches.
  const CorrespondenceSet written = SyntheticSet(3, 40, Rng(1));
  const Example few = make("descriptors: true\nmax_points: 7\n")->Get(0);
  REQUIRE(few.problem.descriptors.rows() == 7);
  for (int i = 0; i < 7; ++i)
    for (int k = 0; k < 40; ++k)
      if (written.pairs[0].problem.points.row(k) == few.problem.points.row(i))
        CHECK(few.problem.descriptors.row(i) == written.pairs[0].problem.descriptors.row(k));
  CHECK_THROWS_AS(make("min_points: 1000\n"), Error);
  CHECK_THROWS_AS(make("task: line\n"), Error);
  CHECK_THROWS_AS(MakeDataset(Config::FromString("type: correspondences\npaths: [nowhere]\n", "test.yaml"), 1), Error);
}

}  // namespace
}  // namespace diffsac
