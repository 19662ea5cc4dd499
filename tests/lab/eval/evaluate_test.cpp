#include "lab/eval/evaluate.h"
#include "lab/config/yaml.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <sstream>

#include "diffsac/core/status.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

const char* kClassical = R"(
name: classical
problems: 30
data: {type: synthetic_line, outlier_ratio: 0.5, split: test}
methods:
  - {name: ransac_20, type: ransac, max_iterations: 20}
  - {name: exhaustive, type: exhaustive, max_problems: 5}
  - {name: oracle, type: oracle}
)";

EvalRequest Request(const TemporaryFolder& folder, const std::string& yaml = kClassical) {
  WriteFileAtomically(folder.File("experiment.yaml"), yaml);
  EvalRequest request;
  request.config_path = folder.File("experiment.yaml");
  request.output = folder.File("out");
  return request;
}

TEST_CASE("an evaluation leaves every file and prints the table") {
  const TemporaryFolder folder;
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  CHECK(Evaluate(Request(folder), {}, stop, out) == kExitOk);
  CHECK_THAT(out.str(), Contains("ransac 20") && Contains("mAA@0.5deg") && Contains("results are in"));
  for (const char* name : {"config.yaml", "problems.csv", "estimates.h5", "run.json"})
    CHECK(std::filesystem::exists(folder.File(std::string("out/") + name)));
  EvalRequest again = Request(folder);
  again.config_path = folder.File("out/config.yaml");  // The resolved configuration runs as well.
  CHECK(ReadRequest(again).methods.size() == 3);
}

TEST_CASE("an interrupted evaluation leaves partial results and says so") {
  const TemporaryFolder folder;
  const std::atomic<bool> stop{true};
  std::ostringstream out;
  CHECK(Evaluate(Request(folder), {}, stop, out) == kExitInterrupted);
  CHECK_THAT(out.str(), Contains("PARTIAL"));
  CHECK_THAT(ReadFile(folder.File("out/run.json")), Contains("\"partial\": true"));
}

TEST_CASE("the command line overrides the configuration") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  request.assignments = {"metric.threshold_deg=2", "data.num_points=50"};
  request.methods = {"oracle"};
  request.limit = 7;
  request.seed = 9;
  request.context.threads = 2;
  const ExperimentOptions experiment = ReadRequest(request);
  CHECK(experiment.threshold_deg == 2.0);
  CHECK(experiment.problems == 7);
  CHECK(experiment.seed == 9);
  CHECK(experiment.threads == 2);
  CHECK(experiment.methods.size() == 1);
  CHECK_THAT(ToYaml(experiment.conditions[0].data), Contains("num_points: 50"));
}

TEST_CASE("the folder of data is the command line's, and what is needed is only printed") {
  const TemporaryFolder folder;
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  EvalRequest request = Request(
      folder,
      "task: plane\ndata: {type: point_sets, task: plane, inlier_threshold: 1, paths: [\"${data_root}/scans\"]}\n"
      "methods: [{type: ransac}]\n");
  request.data_root = "it's data";
  request.needs = true;
  CHECK(Evaluate(request, {}, stop, out) == kExitOk);
  CHECK(out.str() == "it's data/scans\n");
  CHECK_FALSE(std::filesystem::exists(folder.File("out")));
}

TEST_CASE("wrong input is one clear line") {
  const TemporaryFolder folder;
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  EvalRequest request = Request(folder);
  request.methods = {"ransack_20"};
  CHECK_THROWS_WITH(Evaluate(request, {}, stop, out), Contains("ransac_20"));
  request = Request(folder, "methods: [{name: a, type: ransack}]\ndata: {type: synthetic_line}\n");
  CHECK_THROWS_WITH(Evaluate(request, {}, stop, out), Contains("ransack") && Contains("did you mean"));
  request = Request(folder, "methods: [{type: ransac, max_iteration: 3}]\ndata: {type: synthetic_line}\n");
  CHECK_THROWS_WITH(Evaluate(request, {}, stop, out), Contains("max_iterations"));
  request.config_path = folder.File("absent.yaml");
  CHECK_THROWS_WITH(Evaluate(request, {}, stop, out), Contains("absent.yaml"));
  request = Request(folder);
  WriteFileAtomically(folder.File("file"), "x");
  request.output = folder.File("file/out");
  CHECK_THROWS_AS(Evaluate(request, {}, stop, out), Error);
}

TEST_CASE("an experiment without its data is skipped where that is allowed") {
  const TemporaryFolder folder;
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  const std::string yaml =
      "task: plane\ndata: {type: point_sets, task: plane, paths: [nowhere/scans]}\nmethods: [{type: ransac}]\n";
  CHECK(Evaluate(Request(folder, yaml + "missing: leave_out\n"), {}, stop, out) == kExitOk);
  CHECK_THAT(out.str(), Contains("skipped") && Contains("nowhere/scans"));
  CHECK_THROWS_AS(Evaluate(Request(folder, yaml), {}, stop, out), Error);
}

TEST_CASE("a table over seeds without its data is skipped as well, and leaves no folder") {
  const TemporaryFolder folder;
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  const EvalRequest request = Request(folder,
                                      "task: plane\ndata: {type: point_sets, task: plane, paths: [nowhere/scans]}\n"
                                      "methods: [{type: ransac}]\nmissing: leave_out\nseeds: [1, 2]\n");
  CHECK(Evaluate(request, {}, stop, out) == kExitOk);
  CHECK_THAT(out.str(), Contains("skipped") && Contains("nowhere/scans"));
  CHECK(out.str().find("skipped") == out.str().rfind("skipped"));
  CHECK_FALSE(std::filesystem::exists(request.output));
}

TEST_CASE("data below a root that is not there is missing as well") {
  const TemporaryFolder folder;
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  const std::string yaml =
      "task: essential\nmissing: leave_out\ndata: {type: ransac_tutorial, task: essential, root: nowhere/tutorial}\n"
      "methods: [{type: ransac}]\n";
  CHECK(Evaluate(Request(folder, yaml), {}, stop, out) == kExitOk);
  CHECK_THAT(out.str(), Contains("skipped") && Contains("nowhere/tutorial"));
}

std::string RunAgain(EvalRequest request, int code = kExitOk, bool stopped = false) {
  request.update = true;
  const std::atomic<bool> stop{stopped};
  std::ostringstream out;
  CHECK(Evaluate(request, {}, stop, out) == code);
  return out.str();
}

TEST_CASE("a run that is there is not made again") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  CHECK_THAT(RunAgain(request), Contains("mAA@0.5deg"));
  CHECK_THAT(RunAgain(request), Contains("made already"));
  request.assignments = {"methods.0.label=twenty sets"};  // A caption.
  CHECK_THAT(RunAgain(request), Contains("made already"));
  CHECK_THAT(ReadFile(folder.File("out/run.json")), Contains("twenty sets"));
  request.limit = 5;  // Another experiment.
  CHECK_THAT(RunAgain(request), Contains("mAA@0.5deg"));
  std::filesystem::remove(folder.File("out/run.json"));  // Killed before the end.
  CHECK_THAT(RunAgain(request), Contains("mAA@0.5deg"));
  request.rows = true;
  CHECK(RunAgain(request) == "twenty sets\nexhaustive\noracle\n");
}

TEST_CASE("a run that broke off passes for none") {
  const TemporaryFolder folder;
  RunAgain(Request(folder));
  WriteFileAtomically(folder.File("points.csv"), "1,2\nno numbers\n");
  const EvalRequest broken =
      Request(folder, "task: line\ndata: {type: point_sets, task: line, inlier_threshold: 0.1, paths: [" +
                          folder.File("points.csv") + "]}\nmethods: {ransac: {type: ransac}}\n");
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  CHECK_THROWS_AS(Evaluate(broken, {}, stop, out), Error);
  CHECK_FALSE(std::filesystem::exists(folder.File("out/run.json")));
}

TEST_CASE("seeds go on where they were interrupted") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder, std::string(kClassical) + "seeds: [3, 4]\n");
  RunAgain(request, kExitInterrupted, true);
  CHECK_FALSE(std::filesystem::exists(folder.File("out/run.json")));
  RunAgain(request);
  CHECK_THAT(ReadFile(folder.File("out/run.json")), Contains("seed_3") && Contains("seed_4"));
  const std::string file = folder.File("out/seed_4/problems.csv");
  const auto written = std::filesystem::last_write_time(file);
  CHECK_THAT(RunAgain(request), Contains("made already"));
  CHECK(std::filesystem::last_write_time(file) == written);
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  request.shard = "1/2";
  CHECK_THROWS_WITH(Evaluate(request, {}, stop, out), Contains("--shard is for one seed"));
  request.assignments = {"seeds=[1, 1]"};
  CHECK_THROWS_WITH(Evaluate(request, {}, stop, out), Contains("expected different seeds"));
}

}  // namespace
}  // namespace diffsac
