// The pose that a person is given beside the model's (docs/metrics.md#the-pose-that-is-given).

#include <catch2/catch.hpp>
#include <cmath>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "geometry/two_view_problems.h"
#include "lab/eval/eval_fixtures.h"

namespace diffsac {
namespace {

using Catch::Contains;

/// Of noiseless matches the true E, of which a wrong verdict may be said.
struct Pair {
  Example example;
  Estimate estimate;
};

Pair TrueEssential() {
  Rng rng(5);
  const testing::TwoViewProblem views = testing::RandomProblem(50, rng);
  Pair pair;
  pair.example.id = "pair";
  pair.example.scene = "all";
  pair.example.problem.task = Task::kEssential;
  pair.example.problem.points = views.pixels;
  pair.example.problem.cameras = CameraPair{views.k1, views.k2};
  pair.example.truth.pose = views.pose;
  pair.example.truth.model = views.essential;
  pair.estimate.status = Status::kOk;
  pair.estimate.model = views.essential;
  pair.estimate.inliers.assign(50, 1);
  pair.estimate.degeneracy = Degeneracy::kDetermined;
  return pair;
}

void SayTurn(Pair* pair) {
  pair->estimate.degeneracy = Degeneracy::kPureRotation;
  pair->estimate.pure_rotation = pair->example.truth.pose->rotation;
}

ExperimentOptions EssentialExperiment(bool estimates) {
  ExperimentOptions experiment = ReadExperiment(ConfigFromYaml(
      "{name: given, task: essential, metric: {threshold_deg: 10}, data: {type: synthetic_two_view, task: essential}, "
      "methods: [{name: one, type: two_point}]}"));
  experiment.estimates = estimates;
  return experiment;
}

ExperimentResults ResultsOf(const std::vector<Pair>& pairs, bool estimates = true) {
  ExperimentResults results;
  results.experiment = EssentialExperiment(estimates);
  results.cells.push_back({0, 0, {}});
  for (const Pair& pair : pairs) {
    ProblemRecord record = MakeRecord(results.experiment, pair.example, pair.estimate, results.experiment.estimates);
    record.index = results.cells[0].records.size();
    record.id += std::to_string(record.index);
    results.cells[0].records.push_back(std::move(record));
  }
  results.problems = {pairs.size()};
  return results;
}

/// Right, taken back as a turn, and not there.
std::vector<Pair> ThreePairs() {
  std::vector<Pair> pairs(3, TrueEssential());
  SayTurn(&pairs[1]);
  pairs[2].estimate = Estimate();
  return pairs;
}

}  // namespace

TEST_CASE("the given pose is judged not the model") {
  for (const bool estimates : {true, false}) {
    const ExperimentResults results = ResultsOf(ThreePairs(), estimates);
    const auto& records = results.cells[0].records;
    CHECK(records[0].error.pose_deg < 1e-4);
    CHECK(records[1].error.angle_deg < 1e-4);
    CHECK(records[1].error.pose_rotation_deg < 1e-4);
    CHECK(records[1].error.pose_translation_deg == 180.0);
    CHECK(records[1].degeneracy == Degeneracy::kPureRotation);
    CHECK(records[2].error.failed);
    CHECK(records[2].error.pose_deg == 180.0);
  }
}

TEST_CASE("a turned camera is right as a turn") {
  std::vector<Pair> pairs(2, TrueEssential());
  for (Pair& pair : pairs) pair.example.truth.pose->translation.setZero();
  SayTurn(&pairs[0]);
  const ExperimentResults results = ResultsOf(pairs);
  CHECK(results.cells[0].records[0].error.pose_deg < 1e-4);
  CHECK(results.cells[0].records[1].error.angle_deg < 1e-4);
  CHECK(results.cells[0].records[1].error.pose_translation_deg == 180.0);
}

TEST_CASE("files have the given pose") {
  CHECK_THAT(ProblemsCsv(ResultsOf(ThreePairs())),
             Contains(",pose_rotation_deg,pose_translation_deg,pose_deg,degeneracy,has_ambiguous_pose,"
                      "error_probability,largest_coordinate\n") &&
                 Contains(",180,180,pure_rotation,0,,") && Contains(",180,180,180,not_tested,0,,"));
}

}  // namespace diffsac
