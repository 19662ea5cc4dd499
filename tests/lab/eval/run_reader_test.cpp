#include "lab/eval/run_files.h"

#include <catch2/catch.hpp>

#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

TEST_CASE("a run's folder reads back as the results that were written") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  results.cells[0].records[0].id = "a,\"b\"\nc";
  results.cells[0].records[1].status = Status::kDegenerate;
  results.cells[0].records[1].error = {90.0,         3.0,          true,
                                       std::nan(""), std::nan(""), std::numeric_limits<double>::infinity()};
  results.cells[0].records[2].inlier_share = 0.375;
  results.cells[1].records.resize(2);
  results.experiment.left_out = {"Absent (needs no.safetensors)"};
  WriteRun(results, folder.File("run"));
  const ExperimentResults read = ReadRun(folder.File("run"));
  REQUIRE(read.cells.size() == results.cells.size());
  CHECK(read.cells[0].records[0].id == "a,\"b\"\nc");
  CHECK(read.cells[0].records[1].error.failed);
  CHECK(std::isinf(read.cells[0].records[1].error.error_px));
  CHECK(read.cells[0].records[2].inlier_share == 0.375);
  CHECK(std::isnan(read.cells[0].records[2].true_rotation_deg));
  CHECK(read.experiment.left_out == results.experiment.left_out);
  CHECK(read.problems == std::vector<std::size_t>{5, 4});  // "a,b" of the first row is "p0" of the others.
  CHECK(ResultsCsv(MakeReport(read)) == ResultsCsv(MakeReport(results)));
  CHECK(ProblemsCsv(read) == ProblemsCsv(results));
}

TEST_CASE("a run over several structures reads back too") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpInstances();
  results.cells[0].records[0].one_instance_sets = std::nan("");
  WriteRun(results, folder.File("run"));
  const ExperimentResults read = ReadRun(folder.File("run"));
  CHECK(ResultsCsv(MakeReport(read)) == ResultsCsv(MakeReport(results)));
  CHECK(ProblemsCsv(read) == ProblemsCsv(results));
  CHECK(read.experiment.paper[0].second.values.at("0.5").misclassification == 5.25);
  CHECK(read.cells[0].records[0].stats.iterations == 20);
}

TEST_CASE("a run with learned rows reads back, which a dangling list of them once broke") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  for (std::size_t m = 0; m < results.experiment.methods.size(); ++m)
    results.learned.push_back({m, {407258, 72000 + static_cast<std::int64_t>(m), 72000, "a_network_with_a_long_name"}});
  WriteRun(results, folder.File("run"));
  const ExperimentResults read = ReadRun(folder.File("run"));
  REQUIRE(read.learned.size() == results.learned.size());
  for (const LearnedRow& row : read.learned) {
    CHECK(row.facts.samples == 72000 + static_cast<std::int64_t>(row.method));
    CHECK(row.facts.start == "a_network_with_a_long_name");
  }
}

TEST_CASE("what is no run, or damaged, is said with file and line") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(ReadRun(folder.File("none")), Contains("no folder"));
  std::filesystem::create_directories(folder.File("empty"));
  CHECK_THROWS_WITH(ReadRun(folder.File("empty")), Contains("no config.yaml"));
  WriteRun(MadeUpResults(), folder.File("run"));
  const std::string path = folder.File("run/problems.csv"), whole = ReadFile(path);
  WriteFileAtomically(path, whole.substr(0, whole.size() - 9));
  CHECK_THROWS_WITH(ReadRun(folder.File("run")), Contains("problems.csv:25: expected 37 values"));
  std::string wrong = whole;
  wrong.replace(wrong.find(",first,ok,"), 10, ",third,ok,");
  WriteFileAtomically(path, wrong);
  CHECK_THROWS_WITH(ReadRun(folder.File("run")), Contains("problems.csv:2: config.yaml has no method 'third'"));
  wrong = whole;
  wrong.replace(wrong.find("0.045"), 5, "x.045");
  WriteFileAtomically(path, wrong);
  CHECK_THROWS_WITH(ReadRun(folder.File("run")), Contains("angle_deg: 'x.045' is no number"));
  WriteFileAtomically(path, whole);
  WriteFileAtomically(folder.File("run/results.json"), "{");
  CHECK_THROWS_WITH(ReadRun(folder.File("run")), Contains("results.json: not the results.json of a run"));
}

}  // namespace
}  // namespace diffsac
