// The pose that a person is given beside the model's (docs/metrics.md#the-pose-that-is-given).

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "geometry/two_view_problems.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/merge.h"
#include "lab/eval/tables.h"

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
    ProblemRecord record = MakeRecord(results.experiment, pair.example, pair.estimate);
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
    const auto metrics = CellMetrics(results.cells[0], results.experiment.tolerance());
    CHECK(FindMetric(metrics, "mean", "mAA@10deg") == Approx(2.0 / 3.0));
    CHECK(FindMetric(metrics, "mean", "mAA_pose@10deg") == Approx(1.0 / 3.0));
    CHECK(FindMetric(metrics, "mean", "failures") == 1.0);
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

TEST_CASE("tables and files have the given pose") {
  const ExperimentResults results = ResultsOf(ThreePairs());
  const Report report = MakeReport(results);
  const auto table = std::find_if(report.tables.begin(), report.tables.end(), [](const Table& one) {
    return one.heading == "the pose that is given (R, t with its sign) beside the model's";
  });
  REQUIRE(table != report.tables.end());
  REQUIRE(table->columns.size() == 3);
  CHECK_THAT(table->columns[1], Contains("mAA@10deg"));
  CHECK_THAT(table->columns[2], Contains("mAA_pose@10deg"));
  CHECK(table->rows[0].cells[1] == "0.667");
  CHECK(table->rows[0].cells[2] == "0.333");
  CHECK_THAT(ResultsCsv(report), Contains(",mean,all,one,mAA_pose@10deg,0.3333"));
  CHECK_THAT(
      ProblemsCsv(results),
      Contains(",pose_rotation_deg,pose_translation_deg,pose_deg,degeneracy,has_ambiguous_pose,error_probability\n") &&
          Contains(",180,180,pure_rotation,0,\n") && Contains(",180,180,180,not_tested,0,\n"));
}

TEST_CASE("pixel tables judge the pose at ten degrees") {
  CHECK(PoseAccuracyMetric(Tolerance(20.0, true)) == "mAA_pose@10deg");
  CHECK(PoseAccuracyMetric(Tolerance(5.0)) == "mAA_pose@5deg");
}

TEST_CASE("runs and shards keep the given pose") {
  std::vector<Pair> pairs = ThreePairs();
  pairs[0].estimate.ambiguous_pose = RigidMotion{};
  const ExperimentResults results = ResultsOf(pairs);
  const TemporaryFolder folder;
  testing::WriteRun(results, folder.File("run"));
  for (const ExperimentResults& read :
       {ReadRun(folder.File("run")), ReadShardRecords(ShardRecords(results, ""), "here").results}) {
    const auto& records = read.cells[0].records;
    REQUIRE(records.size() == 3);
    CHECK(records[0].has_ambiguous_pose);
    CHECK_FALSE(records[1].has_ambiguous_pose);
    CHECK(records[1].degeneracy == Degeneracy::kPureRotation);
    CHECK(records[1].error.pose_deg == 180.0);
    CHECK(testing::CsvOf(read) == testing::CsvOf(results));
  }
}

TEST_CASE("runs without given poses are read") {
  const TemporaryFolder folder;
  testing::WriteRun(ResultsOf(ThreePairs()), folder.File("run"));
  const std::string path = folder.File("run/problems.csv");
  std::istringstream whole(ReadFile(path));
  std::string earlier;
  for (std::string line; std::getline(whole, line);) {
    for (int column = 0; column < 5; ++column) line.erase(line.rfind(','));
    earlier += line + "\n";
  }
  WriteFileAtomically(path, earlier);
  const ExperimentResults read = ReadRun(folder.File("run"));
  CHECK(std::isnan(read.cells[0].records[1].error.pose_deg));
  CHECK(read.cells[0].records[1].error.angle_deg < 1e-4);
  CHECK_THAT(testing::CsvOf(read), !Contains("mAA_pose"));
}

TEST_CASE("means have every metric of the scenes") {
  // Scene a has two records of each row, b six; what only some records know is a metric all the same.
  for (const std::size_t focal : {8, 0, 5})
    for (const std::size_t given : {8, 0, 5})
      for (const bool one_scene : {true, false}) {
        Cell cell = testing::MadeUpPoses().cells[0];
        if (focal < 8) cell.records[focal].error.focal = 0.02;
        if (given < 8) cell.records[given].error.pose_deg = 3.0;
        if (one_scene) cell.records.erase(cell.records.begin() + 1, cell.records.begin() + 5);
        for (ProblemRecord& record : cell.records) record.scene = one_scene ? "a" : record.scene;
        std::map<std::string, std::set<std::string>> names;
        for (const MetricValue& value : CellMetrics(cell, Tolerance(10.0))) names[value.scene].insert(value.metric);
        REQUIRE(names.size() == (one_scene ? 2 : 4));
        for (const auto& [scene, metrics] : names) CHECK(metrics == names["mean"]);
        CHECK(names["mean"].contains("median_focal_percent") == (focal < 8));
        CHECK(names["mean"].contains("mAA_pose@10deg") == (given < 8));
      }
}

}  // namespace diffsac
