// Rows that run a learned row in their own way (lib/lab/baselines/offered.cpp).
#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "consensus/all_models.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/truth/task_truth.h"

namespace diffsac {
namespace {

/// What a row of this type says: a network, four draws.
Estimate Run(const std::string& type, const Example& example) {
  const std::string yaml = "{type: " + type +
                           ", checkpoint: '" DIFFSAC_SOURCE_DIR
                           "/models/fundamental/model.safetensors', copies: 0, head_sets: 4, extra_sets: 0}";
  const TableRow row = MakeRow(ConfigFromYaml(yaml, "t.yaml"), Task::kFundamental, {"", "cpu", 1});
  return row.Run(example, {"all", 1, 1});
}

/// How many of the matches are inliers of that.
int Found(const std::string& type, const Example& example) {
  const Estimate estimate = Run(type, example);
  return std::accumulate(estimate.inliers.begin(), estimate.inliers.end(), 0);
}

Example Matches(std::uint64_t seed = 3) {
  const auto model = testing::MakeModelProblem<Fundamental>(300, 0.8, Rng(seed));
  Example example;
  example.problem.task = Task::kFundamental;
  example.problem.points = model.points;
  example.problem.inlier_threshold = model.threshold;
  example.truth.model = model.truth;
  return example;
}

TEST_CASE("a row that is offered the true model chooses it where draws do not find it") {
  const Example example = Matches();
  CHECK(Found("diffsac", example) < 45);
  CHECK(Found("offered", example) >= 50);
}

TEST_CASE("of four runs the best has no lower score than one, and none is nearer to the truth than the nearest") {
  double of_one = 0.0, of_nearest = 0.0;
  int better = 0;
  for (std::uint64_t seed = 3; seed < 7; ++seed) {
    Example example = Matches(seed);
    example.truth.inliers.assign(example.problem.points.rows(), 0);
    std::fill_n(example.truth.inliers.end() - 60, 60, 1);
    const auto error = [&](const Estimate& estimate) {
      return TruthOf(Task::kFundamental).error(&estimate.model, estimate.inliers, example).error_px;
    };
    const Estimate one = Run("diffsac", example), best = Run("best_of_four", example);
    const Estimate nearest = Run("nearest_of_four", example);
    CHECK(best.score >= one.score);
    CHECK(error(nearest) <= error(one));
    CHECK(error(nearest) <= error(best));
    better += best.score > one.score ? 1 : 0;
    of_one += error(one);
    of_nearest += error(nearest);
  }
  CHECK(better > 0);
  CHECK(of_nearest < of_one);
}

TEST_CASE("an offered row has the keys and the mistakes of diffsac, and a type of its own") {
  const auto row = [](const std::string& keys) {
    return ConfigFromYaml(
        "{type: offered, checkpoint: '" DIFFSAC_SOURCE_DIR "/models/fundamental/model.safetensors'" + keys + "}",
        "t.yaml");
  };
  const EstimatorContext context{"", "cpu", 1};
  const Config resolved = ResolvedRow(row(", preset: recommended"), Task::kFundamental, context);
  CHECK(resolved.Text("type") == "offered");
  CHECK(resolved.Has("consensus.basins"));
  CHECK(MakeRow(resolved, Task::kFundamental, context).estimator() == nullptr);
  CHECK_THROWS_WITH(MakeRow(row(", head_set: 3"), Task::kFundamental, context), Catch::Contains("'head_sets'"));
}

}  // namespace
}  // namespace diffsac
