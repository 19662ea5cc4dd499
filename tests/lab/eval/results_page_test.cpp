#include "lab/eval/run_files.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <sstream>

#include "diffsac/core/status.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/evaluate.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

EvalRequest UpdateRequest(const TemporaryFolder& folder) {
  WriteFileAtomically(folder.File("x.yaml"),
                      "name: x\nproblems: 8\ndata: {type: synthetic_line, split: test}\n"
                      "methods: {ransac: {type: ransac, max_iterations: 20}}\n");
  EvalRequest request;
  request.config_path = folder.File("x.yaml");
  request.output = folder.File("run");
  request.update = true;
  return request;
}

std::string Run(const EvalRequest& request) {
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  CHECK(Evaluate(request, {}, stop, out) == kExitOk);
  return out.str();
}

TEST_CASE("a run that is there is not made again, one of another configuration, or without its tables, is") {
  const TemporaryFolder folder;
  EvalRequest request = UpdateRequest(folder);
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
  CHECK_THAT(Run(request), Contains("made already"));
  request.limit = 5;  // Another experiment.
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
  CHECK_THAT(Run(request), Contains("made already"));
  std::filesystem::remove(folder.File("run/table.md"));
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
}

TEST_CASE("rows are told by their labels, those of the paper included, and nothing is run") {
  const TemporaryFolder folder;
  EvalRequest request = UpdateRequest(folder);
  request.assignments = {"methods.ransac.label=twenty sets", "paper={DiffSAC: {all: [0.9, 0.1]}}"};
  request.rows = true;
  CHECK(Run(request) == "twenty sets\nDiffSAC\n");
  CHECK_FALSE(std::filesystem::exists(folder.File("run")));
}

TEST_CASE("a run that broke off does not pass for the one whose results were there before") {
  const TemporaryFolder folder;
  EvalRequest request = UpdateRequest(folder);
  Run(request);
  WriteFileAtomically(folder.File("points.csv"), "1,2\nno numbers\n");
  WriteFileAtomically(folder.File("broken.yaml"),
                      "name: x\ntask: line\ndata: {type: point_sets, task: line, paths: [" + folder.File("points.csv") +
                          "], inlier_threshold: 0.1}\nmethods: {ransac: {type: ransac, max_iterations: 20}}\n");
  EvalRequest broken = request;
  broken.config_path = folder.File("broken.yaml");
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  CHECK_THROWS_AS(Evaluate(broken, {}, stop, out), Error);
  CHECK_FALSE(std::filesystem::exists(folder.File("run/results.json")));
  CHECK_THAT(ReadFile(folder.File("run/config.yaml")), Contains("points.csv"));
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
  // Killed after the tables, before pictures and report.
  std::filesystem::remove(folder.File("run/results.json"));
  std::filesystem::remove(folder.File("run/report.html"));
  CHECK_THAT(Run(request), Contains("mAA@0.5deg"));
  CHECK(std::filesystem::exists(folder.File("run/report.html")));
}

}  // namespace
}  // namespace diffsac
