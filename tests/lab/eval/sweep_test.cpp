#include "lab/eval/sweep.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/eval/effects.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/report/command_line.h"
#include "lab/report/run_reader.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

const char* kSwept = R"(
name: swept
problems: 12
data: {type: synthetic_line, split: test}
sweep:
  outlier_ratio: [0.2, 0.5]
  methods.ransac.max_iterations: [5, 50]
  settings.base.consensus.score: [msac, inlier_count]
settings:
  base: {consensus: {local_optimization: irls}}
methods:
  ransac: {type: ransac, label: RANSAC}
  lo: {type: lo_ransac, use: base, max_iterations: 20}
  oracle: {type: oracle}
)";

std::vector<SweepAxis> AxesOf(const std::string& text) { return SweepAxes(ConfigFromYaml(text, "x.yaml")); }

EvalRequest Request(const TemporaryFolder& folder) {
  WriteFileAtomically(folder.File("experiment.yaml"), kSwept);
  EvalRequest request;
  request.config_path = folder.File("experiment.yaml");
  request.output = folder.File("out");
  return request;
}

TEST_CASE("keys with a dot, seed and problems are axes of whole runs, in every combination") {
  const auto axes = AxesOf(kSwept);
  REQUIRE(axes.size() == 2);
  CHECK(axes[0].shown == "max_iterations");
  const auto points = SweepPoints(axes);
  REQUIRE(points.size() == 4);
  CHECK(points[1].name == "max_iterations=5 score=inlier_count");
  CHECK(points[2].assignments ==
        std::vector<std::string>{"methods.ransac.max_iterations=50", "settings.base.consensus.score=msac"});
  CHECK(AxesOf("sweep: {outlier_ratio: [0.1]}").empty());
  CHECK(AxesOf("sweep: {seed: [1, 2], problems: [5]}").size() == 2);
  const auto alike = AxesOf("methods: {a: {}, b: {}}\nsweep: {methods.a.k: [1], methods.b.k: [1], data.c: [2]}");
  CHECK(alike[0].shown == "a.k");
  CHECK(alike[1].shown == "b.k");
  CHECK(alike[2].shown == "c");
}

TEST_CASE("the conditions of a sweep stay when its axes go") {
  const ExperimentOptions rest = ReadExperiment(WithoutSweepAxes(ConfigFromYaml(kSwept, "x.yaml")));
  REQUIRE(rest.conditions.size() == 2);
  CHECK(rest.conditions[1].name == "0.5");
  const ExperimentOptions none = ReadExperiment(WithoutSweepAxes(
      ConfigFromYaml(std::string(kSwept).replace(std::string(kSwept).find("  outlier_ratio"), 28, ""), "x.yaml")));
  CHECK(none.conditions.size() == 1);
}

TEST_CASE("a sweep that says nothing sensible is an error with its line") {
  CHECK_THROWS_WITH(AxesOf("\nsweep: {data.a: 3}"), Contains("x.yaml:2: sweep: data.a: expected a list"));
  CHECK_THROWS_WITH(AxesOf("sweep: {data.a: []}"), Contains("expected a list of values"));
  CHECK_THROWS_WITH(AxesOf("sweep: {data.a: [[1]]}"), Contains("expected plain values"));
  CHECK_THROWS_WITH(AxesOf("sweep: {data.a: [1, 1]}"), Contains("a value stands twice"));
  CHECK_THROWS_WITH(AxesOf("methods: {b: {}}\nsweep: {methods.a.k: [1]}"), Contains("no 'methods.a'"));
  CHECK_THROWS_WITH(AxesOf("methods: [{name: a}]\nsweep: {methods.a.k: [1]}"), Contains("a map by name"));
}

TEST_CASE("a sweep ends in one table, with a row for each value that makes a difference") {
  const TemporaryFolder folder;
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  REQUIRE(Evaluate(Request(folder), {}, stop, out) == kExitOk);
  CHECK_THAT(out.str(), Contains("[4/4] max_iterations=50 score=inlier_count") && Contains("RANSAC, max_iterations=5"));
  const std::string csv = ReadFile(folder.File("out/results.csv"));
  for (const char* row : {",ransac max_iterations=5,", ",ransac max_iterations=50,", ",lo score=msac,",
                          ",lo score=inlier_count,", ",oracle,"})
    CHECK_THAT(csv, Contains(row));
  CHECK_THAT(csv, !Contains("oracle score"));
  CHECK(csv.rfind(",all,0.2,") < csv.find(",all,0.5,"));
  CHECK(std::filesystem::exists(folder.File("out/points/max_iterations=5,score=msac/estimates.h5")));
  // The point alone says the same.
  EvalRequest alone = Request(folder);
  alone.one_point = true;
  alone.assignments = {"methods.ransac.max_iterations=50"};
  alone.output = folder.File("alone");
  REQUIRE(Evaluate(alone, {}, stop, out) == kExitOk);
  const std::string line = ",ransac,mAA@0.5deg,", of_alone = ReadFile(folder.File("alone/results.csv"));
  const auto value = [](const std::string& text, const std::string& key) {
    const std::size_t at = text.find(key) + key.size();
    return text.substr(at, text.find('\n', at) - at);
  };
  CHECK(value(of_alone, line) == value(csv, ",ransac max_iterations=50,mAA@0.5deg,"));
}

std::string ValueAfter(const std::string& text, const std::string& key) {
  const std::size_t at = text.find(key);
  REQUIRE(at != std::string::npos);
  return text.substr(at + key.size(), text.find('\n', at) - at - key.size());
}

TEST_CASE("a sweep over seeds of generated data is their mean, not rows of other problems side by side") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  request.assignments = {"sweep={seed: [1, 2], methods.ransac.max_iterations: [5, 50]}", "data.outlier_ratio=0.5"};
  std::ostringstream out;
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, out) == kExitOk);
  CHECK_THAT(out.str(), Contains("RANSAC, max_iterations=5, mean of 2 seeds") && !Contains("seed=1 |"));
  const std::string metric = ",mAA@0.5deg,", joined = ReadFile(folder.File("out/results.csv"));
  double sum = 0.0;
  for (const char* point : {"seed=1,max_iterations=50", "seed=2,max_iterations=50"})
    sum += std::stod(ValueAfter(ReadFile(folder.File("out/points/") + point + "/results.csv"), ",ransac" + metric));
  CHECK(std::stod(ValueAfter(joined, ",ransac max_iterations=50" + metric)) == Approx(sum / 2.0));
  CHECK(ValueAfter(joined, ",ransac max_iterations=50,problems,") == "24");
}

TEST_CASE("the folder of a sweep reads back as a run; over seeds alone its factors keep their effects") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  WriteFileAtomically(
      folder.File("factors.yaml"),
      "name: f\nproblems: 10\ndata: {type: synthetic_line, split: test, outlier_ratio: 0.5}\n"
      "conditions: [{name: few, data: {num_points: 20}}, {name: many}]\n"
      "factors_base: {type: ransac}\nfactors: {draws: {a: {max_iterations: 2}, b: {max_iterations: 90}}}\n"
      "strata: {by: points, bins: [50], rows: [b]}\nsweep: {seed: [1, 2]}\n");
  request.config_path = folder.File("factors.yaml");
  std::ostringstream out;
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, out) == kExitOk);
  const ExperimentResults joined = ReadRun(folder.File("out"));
  CHECK(joined.problems == std::vector<std::size_t>{20, 20});
  CHECK(joined.experiment.strata[0].rows == std::vector<std::string>{"b"});
  const FactorEffects effects = EffectsOf(joined, 1);
  REQUIRE(effects.size() == 1);
  CHECK(effects[0][1].accuracy->low > 0.0);
  CHECK(effects[0][1].accuracy->mean == DifferenceOf(joined, 1, 1, 0)->mean);
  CHECK_THAT(ReadFile(folder.File("out/sweep.yaml")), Contains("seed: [1, 2]"));
  // Other axes are in the rows' names, which are no combinations then.
  request.output = folder.File("other");
  request.assignments = {"sweep={factors_base.consensus.score: [msac, inlier_count]}"};
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, out) == kExitOk);
  const ExperimentResults other = ReadRun(folder.File("other"));
  CHECK(other.experiment.methods.size() == 4);
  CHECK(other.experiment.factors.empty());
  CHECK(other.experiment.strata[0].rows.empty());
}

TEST_CASE("over seeds alone rows keep names, comparisons and network facts, and deviations are told") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  WriteFileAtomically(folder.File("seeds.yaml"),
                      "name: s\nproblems: 10\ndata: {type: synthetic_line, split: test, outlier_ratio: 0.7}\n"
                      "methods: {few: {type: ransac, max_iterations: 5}, many: {type: ransac, max_iterations: 200}}\n"
                      "compare: [[many, few]]\nsweep: {seed: [3, 4, 5]}\n");
  request.config_path = folder.File("seeds.yaml");
  request.page = folder.File("s.md");
  request.page_command = "make s";
  std::ostringstream out;
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, out) == kExitOk);
  CHECK_THAT(out.str(), Contains("mean of seeds 3, 4, 5") &&
                            Contains("standard deviation over 3 seeds of mAA@0.5deg") &&
                            Contains("differences in mAA@0.5deg") && !Contains("RANSAC, mean of"));
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
  const std::string page = ReadFile(request.page);
  CHECK_THAT(page, Contains("- time: ") && Contains("- peak memory: ") && Contains("- data: sha256 "));
  CHECK(ReadRun(folder.File("out")).seeds == std::vector<std::uint64_t>{3, 4, 5});
}

TEST_CASE("over seeds alone a row is one row, though its options or its network are the seed's") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  WriteFileAtomically(folder.File("seeds.yaml"),
                      "name: s\nseed: 1\nproblems: 10\ndata: {type: synthetic_line, split: test, outlier_ratio: 0.7}\n"
                      "methods: {few: {type: ransac, max_iterations: \"${seed}\"}}\nsweep: {seed: [3, 40]}\n");
  request.config_path = folder.File("seeds.yaml");
  std::ostringstream out;
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, out) == kExitOk);
  const ExperimentResults joined = ReadRun(folder.File("out"));
  REQUIRE(joined.experiment.methods.size() == 1);
  CHECK(joined.experiment.methods[0].name == "few");
  CHECK(joined.cells[0].records.size() == 20);
}

TEST_CASE("a problem that several seeds share counts once in an interval") {
  Cell cell{0, 0, {}, {}};
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

TEST_CASE("no row is the best of rows that are of different problems") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  request.methods = {"ransac"};
  request.assignments = {"data.outlier_ratio=0.5", "sweep={methods.ransac.max_iterations: [5, 50]}"};
  std::ostringstream same, different;
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, same) == kExitOk);
  CHECK_THAT(same.str(), Contains("**"));
  request.assignments.back() = "sweep={data.noise_scale: [0.02, 0.05]}";
  request.output = folder.File("other");
  REQUIRE(Evaluate(request, {}, std::atomic<bool>{false}, different) == kExitOk);
  CHECK_THAT(different.str(), !Contains("**") && Contains("Rows are of different problems"));
}

TEST_CASE("an interrupted sweep goes on where it was, and points that are there stay") {
  const TemporaryFolder folder;
  std::ostringstream out;
  const std::atomic<bool> stopped{true}, stop{false};
  CHECK(Evaluate(Request(folder), {}, stopped, out) == kExitInterrupted);
  CHECK_FALSE(std::filesystem::exists(folder.File("out/results.csv")));
  REQUIRE(Evaluate(Request(folder), {}, stop, out) == kExitOk);
  const std::string point = folder.File("out/points/max_iterations=50,score=msac/problems.csv");
  const auto written = std::filesystem::last_write_time(point);
  REQUIRE(Evaluate(Request(folder), {}, stop, out) == kExitOk);
  CHECK(std::filesystem::last_write_time(point) == written);
}

TEST_CASE("a wrong value of a sweep is found before anything runs") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  WriteFileAtomically(request.config_path, std::string(kSwept) + "  x: {type: ransac}\n");
  std::ostringstream out;
  request.assignments = {"sweep={settings.base.consensus.score: [msac, masc]}"};
  CHECK_THROWS_WITH(Evaluate(request, {}, std::atomic<bool>{false}, out), Contains("masc"));
}

TEST_CASE("shards of a sweep are refused") {
  const TemporaryFolder folder;
  EvalRequest request = Request(folder);
  request.shard = "1/2";
  std::ostringstream out;
  CHECK_THROWS_WITH(Evaluate(request, {}, std::atomic<bool>{false}, out), Contains("one process"));
}

}  // namespace
}  // namespace diffsac
