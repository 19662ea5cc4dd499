// The row `offered` (lib/lab/baselines/offered.cpp).
#include <catch2/catch.hpp>
#include <numeric>

#include "consensus/all_models.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"

namespace diffsac {
namespace {

/// How many of the matches of a problem are inliers of what a row says: a network, four draws.
int Found(const std::string& type, const Example& example) {
  const std::string yaml = "{type: " + type +
                           ", checkpoint: '" DIFFSAC_SOURCE_DIR
                           "/models/fundamental/model.safetensors', copies: 0, head_sets: 4, extra_sets: 0}";
  const TableRow row = MakeRow(ConfigFromYaml(yaml, "t.yaml"), Task::kFundamental, {"", "cpu", 1});
  const Estimate estimate = row.Run(example, {"all", 1, 1});
  return std::accumulate(estimate.inliers.begin(), estimate.inliers.end(), 0);
}

TEST_CASE("a row that is offered the true model chooses it where draws do not find it") {
  const auto model = testing::MakeModelProblem<Fundamental>(300, 0.8, Rng(3));
  Example example;
  example.problem.task = Task::kFundamental;
  example.problem.points = model.points;
  example.problem.inlier_threshold = model.threshold;
  example.truth.model = model.truth;
  CHECK(Found("diffsac", example) < 45);
  CHECK(Found("offered", example) >= 50);
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
