#include "lab/eval/evaluate.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/report.h"
#include "lab/eval/run_files.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

const char* kSeeds = R"(
name: seeds
problems: 10
seeds: [3, 4, 5]
data: {type: synthetic_line, split: test, outlier_ratio: 0.7}
methods: {few: {type: ransac, label: Few, max_iterations: 5}, many: {type: ransac, max_iterations: 200}}
compare: [[many, few]]
)";

EvalRequest Request(const TemporaryFolder& folder, const std::string& text = kSeeds) {
  WriteFileAtomically(folder.File("experiment.yaml"), text);
  EvalRequest request;
  request.config_path = folder.File("experiment.yaml");
  request.output = folder.File("out");
  return request;
}

std::string ValueAfter(const std::string& text, const std::string& key) {
  const std::size_t at = text.find(key);
  REQUIRE(at != std::string::npos);
  return text.substr(at + key.size(), text.find('\n', at) - at - key.size());
}

TEST_CASE("the folder of several seeds reads back as a run, and its factors keep their effects") {
  const TemporaryFolder folder;
  const EvalRequest request =
      Request(folder,
              "name: f\nproblems: 10\ndata: {type: synthetic_line, split: test, outlier_ratio: 0.5}\n"
              "conditions: [{name: few, data: {num_points: 20}}, {name: many}]\nfactors: {draws: [a, b]}\n"
              "methods: {a: {type: ransac, max_iterations: 2}, b: {type: ransac, max_iterations: 90}}\n"
              "strata: {by: points, bins: [50], rows: [b]}\nseeds: [1, 2]\n");
  std::ostringstream out;
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, out) == kExitOk);
  const ExperimentResults joined = ReadRun(folder.File("out"));
  CHECK(joined.problems == std::vector<std::size_t>{20, 20});
  CHECK(joined.experiment.strata[0].rows == std::vector<std::string>{"b"});
  const FactorEffects effects = EffectsOf(joined, 1);
  REQUIRE(effects.size() == 1);
  CHECK(effects[0][1].accuracy->low > 0.0);
  CHECK(effects[0][1].accuracy->mean == DifferenceOf(joined, 1, 1, 0)->mean);
  CHECK(joined.experiment.seeds == std::vector<int>{1, 2});
}

TEST_CASE("the table of several seeds is their mean, with deviations") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  std::ostringstream out;
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, out) == kExitOk);
  CHECK_THAT(out.str(), Contains("mean of seeds 3, 4, 5") &&
                            Contains("standard deviation over 3 seeds of mAA@0.5deg") && !Contains("RANSAC, mean of"));
  const std::string joined = ReadFile(folder.File("out/results.csv")), metric = ",mAA@0.5deg,";
  std::vector<double> values;
  for (const char* seed : {"3", "4", "5"})
    values.push_back(std::stod(
        ValueAfter(ReadFile(folder.File("out/points/seed=") + seed + "/results.csv"), "mean,all,few" + metric)));
  const double mean = (values[0] + values[1] + values[2]) / 3.0;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  CHECK(std::stod(ValueAfter(joined, "mean,all,few" + metric)) == Approx(mean));
  CHECK(std::stod(ValueAfter(joined, "mean_seed_deviation,all,few" + metric)) == Approx(std::sqrt(squares / 2.0)));
  CHECK(ReadRun(folder.File("out")).seeds == std::vector<std::uint64_t>{3, 4, 5});
}

TEST_CASE("a row is one row, though its options or its network are the seed's") {
  const TemporaryFolder folder;
  const EvalRequest request =
      Request(folder,
              "name: s\nseed: 1\nproblems: 10\ndata: {type: synthetic_line, split: test, outlier_ratio: 0.7}\n"
              "methods: {few: {type: ransac, max_iterations: \"${seed}\"}}\nseeds: [3, 40]\n");
  std::ostringstream out;
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, out) == kExitOk);
  const ExperimentResults joined = ReadRun(folder.File("out"));
  REQUIRE(joined.experiment.methods.size() == 1);
  CHECK(joined.experiment.methods[0].name == "few");
  CHECK(joined.cells[0].records.size() == 20);
}

TEST_CASE("a problem that several seeds share counts once in an interval") {
  Cell cell{0, 0, {}};
  for (const double value : {1.0, 3.0, 5.0, 9.0}) {
    ProblemRecord record;
    record.index = cell.records.size() % 2;
    record.scene = "a";
    record.error.offset = value;
    cell.records.push_back(record);
  }
  const auto values = SceneValuesOf(cell, [](const ProblemRecord& record) { return record.error.offset; });
  CHECK(values == SceneValues{{3.0, 6.0}});
}

TEST_CASE("interrupted seeds go on where they were, and those that are there stay") {
  const TemporaryFolder folder;
  std::ostringstream out;
  const std::atomic<bool> stopped{true}, stop{false};
  CHECK(Evaluate(Request(folder), {}, stopped, out) == kExitInterrupted);
  CHECK_FALSE(std::filesystem::exists(folder.File("out/results.csv")));
  REQUIRE(Evaluate(Request(folder), {}, stop, out) == kExitOk);
  const std::string point = folder.File("out/points/seed=5/problems.csv");
  const auto written = std::filesystem::last_write_time(point);
  REQUIRE(Evaluate(Request(folder), {}, stop, out) == kExitOk);
  CHECK(std::filesystem::last_write_time(point) == written);
}

TEST_CASE("one seed of several can be chosen, wrong ones, and shards of several, are refused") {
  const TemporaryFolder folder;
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  EvalRequest request = Request(folder);
  request.seed = 4;
  REQUIRE(Evaluate(request, {}, stop, out) == kExitOk);
  CHECK(ReadRun(request.output).seeds.empty());
  CHECK(ReadRun(request.output).experiment.seed == 4);
  request.seed = -1;
  request.shard = "1/2";
  CHECK_THROWS_WITH(Evaluate(request, {}, stop, out), Contains("one process"));
  request.assignments = {"seeds=[1, 1]"};
  CHECK_THROWS_WITH(Evaluate(request, {}, stop, out), Contains("--set seeds=[1, 1]: expected different seeds"));
  request.assignments = {"seeds=[]"};
  CHECK_THROWS_WITH(Evaluate(request, {}, stop, out), Contains("expected a list of seeds"));
}

}  // namespace
}  // namespace diffsac
