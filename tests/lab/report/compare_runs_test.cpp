#include "lab/report/compare_runs.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/eval/eval_fixtures.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

TEST_CASE("equal runs differ in nothing") {
  const RunComparison comparison = CompareRuns(MadeUpResults(), MadeUpResults(), "a", "b");
  CHECK(comparison.rows.size() == 6);
  for (const RowComparison& row : comparison.rows) {
    REQUIRE(row.difference);
    CHECK(row.difference->mean == 0.0);
    CHECK(row.problems == 4);
  }
  CHECK(comparison.changed.empty());
  CHECK(comparison.only_one.empty());
  CHECK(comparison.configuration.empty());
}

TEST_CASE("problems are paired by scene and id, whatever their order, and the largest change comes first") {
  const ExperimentResults a = MadeUpResults();
  ExperimentResults b = MadeUpResults();
  b.cells[0].records[1].error.angle_deg = 40.0;  // was .09
  b.cells[0].records[3].error.angle_deg = 0.2;   // was .18
  std::reverse(b.cells[0].records.begin(), b.cells[0].records.end());
  b.cells[0].records.pop_back();  // p0
  const RunComparison comparison = CompareRuns(a, b, "a", "b");
  const RowComparison& row = comparison.rows.front();
  CHECK(row.problems == 3);
  CHECK(row.only_a == 1);
  CHECK(row.only_b == 0);
  // mAA@.5 of p1, p2, p3: (.9 + .8 + .7) / 3 and (0 + .8 + .7) / 3.
  CHECK(row.a == Approx(0.8));
  CHECK(row.difference->mean == Approx(-0.3));
  CHECK(row.difference->low <= -0.3);
  REQUIRE(comparison.changed.size() == 2);
  CHECK(comparison.changed[0].id == "p1");
  CHECK(comparison.changed[0].accuracy_change == Approx(-0.9));
  CHECK(comparison.changed[1].id == "p3");
}

TEST_CASE("generated problems of another seed are not compared with each other (the oracle changed from .02 to .33)") {
  const auto run = [](std::uint64_t seed) {
    ExperimentOptions experiment = SmallExperiment();
    experiment.seed = seed;
    return RunExperiment(experiment, TwoPointInputs());
  };
  CHECK(CompareRuns(run(1), run(1), "a", "b").changed.empty());
  CHECK_THROWS_WITH(CompareRuns(run(1), run(2), "a", "b"), Contains("no row on the same problems") &&
                                                               Contains("drawn with another seed") &&
                                                               Contains("line/test/0@"));
}

TEST_CASE("the estimates of several seeds of one problem are compared each with its own") {
  ExperimentResults a = MadeUpResults(), b = MadeUpResults();
  for (ExperimentResults* results : {&a, &b})
    for (Cell& cell : results->cells) {
      const auto again = cell.records;
      cell.records.insert(cell.records.end(), again.begin(), again.end());
    }
  a.cells[0].records[4].error.angle_deg = b.cells[0].records[4].error.angle_deg = 0.4;
  const RunComparison comparison = CompareRuns(a, b, "a", "b");
  CHECK(comparison.changed.empty());
  CHECK(comparison.rows.front().problems == 8);
}

TEST_CASE("runs over several structures are compared by recall") {
  const ExperimentResults a = MadeUpStructures();
  ExperimentResults b = MadeUpStructures();
  b.cells[0].records[1].error.recall = 0.0;
  b.cells[1].records[2].error.misclassified += 1.0;
  const RunComparison comparison = CompareRuns(a, b, "a", "b");
  CHECK(comparison.metric == "recall");
  CHECK(comparison.rows.front().a == 1.0);
  CHECK(comparison.rows.front().b == 0.75);
  CHECK(comparison.rows.front().difference->mean == Approx(-0.25));
  REQUIRE(comparison.changed.size() == 2);
  CHECK(comparison.changed[0].accuracy_change == -1.0);
  CHECK(comparison.changed[1].id == "p2");
  CHECK_THROWS_WITH(CompareRuns(a, MadeUpResults(), "a", "b"), Contains("different metrics: recall and mAA@0.5deg"));
}

TEST_CASE("rows, conditions and keys that one run has alone are named") {
  ExperimentResults a = MadeUpResults(), b = MadeUpResults();
  b.experiment.methods[1].name = "other";
  b.experiment.conditions[1].name = "0.7";
  b.experiment.seed = 12;
  const RunComparison comparison = CompareRuns(a, b, "before", "after");
  CHECK(comparison.rows.size() == 2);  // Rows first and oracle on 0.2.
  CHECK_THAT(comparison.only_one, Catch::VectorContains(std::string("row 'second' is in before alone")));
  CHECK_THAT(comparison.only_one, Catch::VectorContains(std::string("row 'other' is in after alone")));
  CHECK_THAT(comparison.only_one, Catch::VectorContains(std::string("condition '0.7' is in after alone")));
  CHECK_THAT(comparison.configuration, Catch::VectorContains(std::string("seed: 3 → 12")));
}

TEST_CASE("runs of one row each are compared whatever the rows are called") {
  ExperimentResults a = MadeUpResults(), b = MadeUpResults();
  for (auto* run : {&a, &b}) {
    run->experiment.methods.resize(1);
    run->cells = {run->cells[0]};
  }
  b.experiment.methods[0].name = "renamed";
  b.experiment.methods[0].label = "Renamed";
  CHECK(CompareRuns(a, b, "a", "b").rows.at(0).row == "First → Renamed");
}

TEST_CASE("runs without truth are compared by their inliers") {
  ExperimentResults a = MadeUpResults(), b = MadeUpResults();
  for (auto* run : {&a, &b})
    for (Cell& cell : run->cells)
      for (ProblemRecord& record : cell.records) record.error = {};
  b.cells[0].records[2].inliers = 3;
  const RunComparison comparison = CompareRuns(a, b, "a", "b");
  CHECK(comparison.metric == "inliers");
  CHECK_FALSE(comparison.rows[0].difference);
  CHECK(comparison.rows[0].a == 20);
  REQUIRE(comparison.changed.size() == 1);
  CHECK(comparison.changed[0].id == "p2");
}

TEST_CASE("runs that cannot be compared are refused") {
  ExperimentResults a = MadeUpResults(), b = MadeUpResults();
  b.experiment.threshold_deg = 2.0;
  CHECK_THROWS_WITH(CompareRuns(a, b, "a", "b"), Contains("different metrics: mAA@0.5deg and mAA@2deg"));
  b = MadeUpResults();
  b.experiment.task = TaskFromString("plane");
  CHECK_THROWS_WITH(CompareRuns(a, b, "a", "b"), Contains("different tasks: line and plane"));
  b = MadeUpResults();
  for (Cell& cell : b.cells)
    for (ProblemRecord& record : cell.records) record.id += "x";
  CHECK_THROWS_WITH(CompareRuns(a, b, "a", "b"), Contains("share no row on the same problems"));
}

TEST_CASE("two folders are compared on the terminal, as files and as a page") {
  const TemporaryFolder folder;
  ExperimentResults b = MadeUpResults();
  b.cells[0].records[1].status = Status::kNoModel;
  b.cells[0].records[1].error = {90.0, 3.0, true};
  b.experiment.methods[0].label = "<b>";
  int at = 0;
  for (const ExperimentResults& results : {MadeUpResults(), b}) {
    const std::string run = folder.File("run" + std::to_string(at++));
    std::filesystem::create_directories(run);
    WriteFileAtomically(run + "/config.yaml", WriteExperiment(results.experiment));
    WriteResults(MakeReport(results), run);
    EndResults(MakeReport(results), run);
  }
  std::ostringstream out;
  CompareFolders({folder.File("run0"), folder.File("run1/")}, folder.File("out"), out);
  CHECK_THAT(out.str(), Contains("run1 against run0") && Contains("no_model") && Contains("95 % paired bootstrap"));
  CHECK_THAT(out.str(), Contains(ReadFile(folder.File("out/compare.md"))));
  CHECK_THAT(ReadFile(folder.File("out/compare.csv")), Contains("B − A"));
  CHECK_THAT(ReadFile(folder.File("out/report.html")), Contains("problems that changed most") && !Contains("<b>\""));
  CHECK_THROWS_WITH(CompareFolders({folder.File("run0"), folder.File("nothing")}, "", out), Contains("no folder"));
}

}  // namespace
}  // namespace diffsac
