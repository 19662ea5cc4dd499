#include "lab/eval/merge.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <limits>
#include <sstream>

#include "diffsac/core/status.h"
#include "lab/eval/estimates.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/evaluate.h"
#include "lab/eval/run_files.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

ShardContent RunShard(const ExperimentOptions& experiment, int index, int count, int batch = 1,
                      const std::string& setup = "") {
  RunInputs inputs = TwoPointInputs(batch);
  inputs.shard = {index, count};
  const auto results = RunExperiment(experiment, inputs);
  return ReadShardRecords(ShardRecords(results, setup), "part" + std::to_string(index));
}

std::vector<ShardContent> RunShards(const ExperimentOptions& experiment, int count, int batch = 1) {
  std::vector<ShardContent> shards;
  for (int i = count; i >= 1; --i) shards.push_back(RunShard(experiment, i, count, batch));
  return shards;
}

// Gives each estimate the size of its batch: stands for a network whose outputs depend on the batch.
class BatchSensitive : public TwoPointEstimator {
 public:
  using TwoPointEstimator::TwoPointEstimator;
  std::vector<diffsac::Estimate> DoRunBatch(std::span<const NormalizedProblem> problems,
                                            std::span<const std::uint64_t> seeds) const override {
    std::vector<diffsac::Estimate> estimates;
    for (std::size_t i = 0; i < problems.size(); ++i) {
      estimates.push_back(DoRun(problems[i], seeds[i]));
      estimates.back().stats.hypotheses = static_cast<int>(problems.size());
    }
    return estimates;
  }
};

}  // namespace

TEST_CASE("shards are parts of the problems, batches stay together") {
  CHECK(ShardPositions(5, 1, {2, 2}) == std::vector<std::size_t>{1, 3});
  CHECK(ShardPositions(10, 4, {1, 2}) == std::vector<std::size_t>{0, 1, 2, 3, 8, 9});
  CHECK(ShardPositions(3, 4, {2, 2}).empty());
  for (const int count : {1, 2, 3, 7}) {
    std::vector<int> seen(23, 0);
    for (int i = 1; i <= count; ++i)
      for (const std::size_t position : ShardPositions(23, 4, {i, count})) ++seen[position];
    CHECK(seen == std::vector<int>(23, 1));
  }
}

TEST_CASE("a shard is written as i/n") {
  CHECK(ShardFromText("2/3") == Shard{2, 3});
  CHECK(ToString(Shard{2, 3}) == "2/3");
  for (const char* text :
       {"", "2", "0/3", "4/3", "1/0", "1/-2", "-1/2", "1/2/3", "a/b", "1.5/2", "1/2 ", "/", "9999999999/9999999999"})
    CHECK_THROWS_WITH(ShardFromText(text), Contains("--shard") && Contains("1 <= i <= n"));
}

TEST_CASE("any sharding gives the same numbers as one run") {
  ExperimentOptions experiment = SmallExperiment();
  experiment.scene_groups = {{"lines", {"al*"}}};
  for (const int batch : {1, 7}) {
    const ExperimentResults whole = RunExperiment(experiment, TwoPointInputs(batch));
    for (const int count : {1, 2, 3, 50}) {
      const ExperimentResults merged = MergeShards(RunShards(experiment, count, batch));
      CHECK(WithoutTimes(CsvOf(merged)) == WithoutTimes(CsvOf(whole)));
      REQUIRE(merged.cells.size() == whole.cells.size());
      for (std::size_t c = 0; c < whole.cells.size(); ++c)
        for (std::size_t i = 0; i < whole.cells[c].records.size(); ++i)
          CHECK(merged.cells[c].records[i].error.angle_deg == whole.cells[c].records[i].error.angle_deg);
    }
  }
}

TEST_CASE("methods see the same batches in any sharding") {
  const auto run = [](const Shard& shard) {
    RunInputs inputs = TwoPointInputs();
    inputs.make_row = [](const Config&, Task) { return std::make_unique<BatchSensitive>(16); };
    inputs.shard = shard;
    return ReadShardRecords(ShardRecords(RunExperiment(SmallExperiment(), inputs), ""), "part");
  };
  const auto merged = MergeShards({run({1, 2}), run({2, 2})});
  CHECK(WithoutTimes(CsvOf(merged)) == WithoutTimes(CsvOf(run({1, 1}).results)));
  CHECK(merged.Find(0, 0)->records.back().stats.hypotheses == 8);  // 40 problems: 16, 16, 8
}

TEST_CASE("a shard's records read back to the same bits") {
  ExperimentResults results = MadeUpResults();
  results.problems = {4, 4};
  results.learned = {{1, {1234, 50, 100, "start"}}};
  results.experiment.left_out = {"Absent (needs no.safetensors)"};
  ProblemRecord& record = results.cells[1].records[2];
  record.id = "a \"b\", c\n|\u00e9";
  record.status = Status::kDegenerate;
  record.error = {0.1 + 0.2, 5e-324, true, std::nan(""), std::numeric_limits<double>::infinity(), -0.0};
  record.all_inlier_sets = 1.0 / 3.0;
  record.error.misclassified = 100.0 / 7.0;
  record.error.recall = 2.0 / 3.0;
  record.one_instance_sets = 1.0 / 20.0;
  record.instances_in_sets = 0.1 + 0.2;
  record.inlier_share = 1.0 / 9.0;
  record.true_rotation_deg = 0.7;
  record.levels = {0.1 + 0.2, 1.0};
  record.instance_count = 3;
  record.stats = {7, 5, 1e-300, 1.0 / 7.0, 3.0, 1e300, 5'000'000'000};
  const ShardContent content = ReadShardRecords(ShardRecords(results, "device: cpu\n"), "here");
  CHECK(content.setup == "device: cpu\n");
  const ProblemRecord& read = content.results.cells[1].records[2];
  CHECK(read.id == record.id);
  CHECK(read.status == record.status);
  CHECK(read.error.angle_deg == record.error.angle_deg);
  CHECK(read.error.offset == record.error.offset);
  CHECK(read.error.failed);
  CHECK(std::isnan(read.error.rotation_deg));
  CHECK(read.error.translation_deg == record.error.translation_deg);
  CHECK(std::signbit(read.error.error_px));
  CHECK(read.points == record.points);
  CHECK(read.all_inlier_sets == record.all_inlier_sets);
  CHECK(read.error.misclassified == record.error.misclassified);
  CHECK(read.error.recall == record.error.recall);
  CHECK(read.one_instance_sets == record.one_instance_sets);
  CHECK(read.instances_in_sets == record.instances_in_sets);
  CHECK(read.inlier_share == record.inlier_share);
  CHECK(read.true_rotation_deg == record.true_rotation_deg);
  CHECK(std::isnan(read.true_baseline));
  CHECK(read.levels.rotation == record.levels.rotation);
  CHECK(read.levels.translation == 1.0);
  CHECK(read.instance_count == 3);
  CHECK(read.stats.iterations == 5'000'000'000);
  CHECK(std::isnan(content.results.cells[1].records[1].error.recall));
  CHECK(read.stats.unique_minimal_sets == 5);
  CHECK(read.stats.ms_features == record.stats.ms_features);
  CHECK(read.stats.ms_network == record.stats.ms_network);
  CHECK(read.stats.ms_total == record.stats.ms_total);
  CHECK(CsvOf(content.results) == CsvOf(results));
  CHECK(ProblemsCsv(content.results) == ProblemsCsv(results));
  CHECK(MarkdownReport(MakeReport(content.results)) == MarkdownReport(MakeReport(results)));
  CHECK_THAT(ResultsJson(MakeReport(content.results), ""),
             Contains("1234") && Contains("100") && Contains("start") && Contains("Absent (needs no.safetensors)"));
}

TEST_CASE("shards that are not one whole run are one clear line") {
  const ExperimentOptions experiment = SmallExperiment();
  const auto shards = RunShards(experiment, 3);  // 3/3, 2/3, 1/3
  CHECK_THROWS_WITH(MergeShards({}), Contains("expected the folders"));
  CHECK_THROWS_WITH(MergeShards({shards[0], shards[2]}), Contains("shard 2/3 is missing") && Contains("2 of 3"));
  CHECK_THROWS_WITH(MergeShards({shards[1], shards[2]}), Contains("shard 3/3 is missing"));
  CHECK_THROWS_WITH(MergeShards({shards[0], shards[1], shards[2], shards[1]}), Contains("are both shard 2/3"));
  CHECK_THROWS_WITH(MergeShards({RunShard(experiment, 1, 2), shards[1]}), Contains("different splits"));

  ExperimentOptions other = experiment;
  other.seed = 4;
  CHECK_THROWS_WITH(MergeShards({shards[2], RunShard(other, 2, 3), shards[0]}),
                    Contains("different configurations: 'seed: 3' and 'seed: 4'"));
  CHECK_THROWS_WITH(MergeShards({shards[2], RunShard(experiment, 2, 3, 1, "device: cuda\n"), shards[0]}),
                    Contains("were run differently"));
  other = experiment;
  other.threads = 2;  // Changes no result.
  CHECK_NOTHROW(MergeShards({shards[2], RunShard(other, 2, 3), shards[0]}));

  auto changed = shards;
  changed[1].results.partial = true;
  CHECK_THROWS_WITH(MergeShards(changed), Contains("part2 (shard 2/3) was interrupted"));
  changed = shards;
  changed[1].results.problems[0] = 39;
  CHECK_THROWS_WITH(MergeShards(changed), Contains("saw different data"));
  changed = shards;
  changed[1].results.cells[0].records.pop_back();
  CHECK_THROWS_WITH(MergeShards(changed), Contains("method 'first', condition '0.2'") && Contains("40 problems"));
}

TEST_CASE("interrupted shards may join to partial results") {
  auto shards = RunShards(SmallExperiment(), 2);
  shards[0].results.partial = true;
  shards[0].results.cells.pop_back();
  const ExperimentResults joined = MergeShards(shards, true);
  CHECK(joined.partial);
  CHECK_THAT(MarkdownReport(MakeReport(joined)), Contains("Partial"));
  CHECK(joined.Find(0, 0)->records.size() == 40);
}

TEST_CASE("damaged records are one clear line") {
  RunInputs inputs = TwoPointInputs();
  inputs.shard = {1, 2};
  const std::string text = ShardRecords(RunExperiment(SmallExperiment(), inputs), "");
  const auto with_problems = [&](const std::string& number) {
    std::string other = text;
    const std::size_t at = other.find("\"problems\":[") + 12;
    return other.replace(at, other.find_first_of(",]", at) - at, number);
  };
  for (const std::string& damaged :
       {std::string(), std::string("x"), std::string("{}"), std::string("[1]\n"), text.substr(0, text.size() / 2),
        text.substr(0, text.rfind('\n', text.size() - 2) + 1), text + "[1,2]\n",
        text + "[99,0,0,\"\",\"\",\"ok\",false]\n",
        // Converted to an integer, which none is.
        with_problems("4e300"), with_problems("-1"), with_problems("4.5"), with_problems("99999999999999999999")})
    CHECK_THROWS_WITH(ReadShardRecords(damaged, "folder"), Contains("folder: not a shard's records.jsonl"));
}

namespace {

const char* kClassical = R"(
name: classical
problems: 30
data: {type: synthetic_line, split: test}
conditions:
  - {name: few, value: 0.2, data: {outlier_ratio: 0.2}}
  - {name: many, value: 0.6, data: {outlier_ratio: 0.6}}
methods:
  - {name: ransac_20, type: ransac, max_iterations: 20}
  - {name: lo_ransac, type: lo_ransac, max_iterations: 20}
  - {name: exhaustive, type: exhaustive, max_problems: 5}
  - {name: oracle, type: oracle}
compare: [[lo_ransac, ransac_20]]
)";

// Runs the program's work; its exit status.
int Run(const TemporaryFolder& folder, const std::string& output, const std::string& shard, bool stopped = false) {
  WriteFileAtomically(folder.File("experiment.yaml"), kClassical);
  EvalRequest request;
  request.config_path = folder.File("experiment.yaml");
  request.output = folder.File(output);
  request.shard = shard;
  const std::atomic<bool> stop{stopped};
  std::ostringstream out;
  return Evaluate(request, {}, stop, out);
}

int Merge(const TemporaryFolder& folder, const std::string& output, const std::vector<std::string>& parts) {
  EvalRequest request;
  request.output = folder.File(output);
  for (const std::string& part : parts) request.merge.push_back(folder.File(part));
  const std::atomic<bool> stop{false};
  std::ostringstream out;
  const int status = Evaluate(request, {}, stop, out);
  CHECK_THAT(out.str(), Contains("ransac 20") && Contains("mAA@0.5deg"));
  return status;
}

std::string Results(const TemporaryFolder& folder, const std::string& run) {
  return WithoutTimes(ReadFile(folder.File(run + "/results.csv")));
}

}  // namespace

TEST_CASE("folders of shards become the folder of the whole run") {
  const TemporaryFolder folder;
  CHECK(Run(folder, "whole", "") == kExitOk);
  for (const std::string part : {"1/2", "2/2", "1/3", "2/3", "3/3"}) {
    const std::string output = "part_" + part.substr(0, 1) + "_" + part.substr(2);
    CHECK(Run(folder, output, part) == kExitOk);
    CHECK(std::filesystem::exists(folder.File(output + "/problems.csv")));
    CHECK_FALSE(std::filesystem::exists(folder.File(output + "/results.csv")));  // It would not be the table's.
  }
  CHECK(Merge(folder, "two", {"part_2_2", "part_1_2"}) == kExitOk);
  CHECK(Merge(folder, "three", {"part_1_3", "part_2_3", "part_3_3"}) == kExitOk);
  CHECK(Results(folder, "two") == Results(folder, "whole"));
  CHECK(Results(folder, "three") == Results(folder, "whole"));
  const EstimateFile whole = ReadEstimates(folder.File("whole/estimates.h5")),
                     three = ReadEstimates(folder.File("three/estimates.h5"));
  REQUIRE(whole.groups.size() == 8);
  REQUIRE(three.groups.size() == 8);
  for (std::size_t g = 0; g < 8; ++g) {
    REQUIRE(three.groups[g].records.size() == whole.groups[g].records.size());
    for (std::size_t i = 0; i < whole.groups[g].records.size(); ++i) {
      CHECK(three.groups[g].records[i].id == whole.groups[g].records[i].id);
      CHECK(three.groups[g].records[i].model == whole.groups[g].records[i].model);
      CHECK(three.groups[g].records[i].inlier_rows == whole.groups[g].records[i].inlier_rows);
    }
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder.File("whole")))
    CHECK(std::filesystem::exists(folder.File("three/" + entry.path().filename().string())));
}

TEST_CASE("folders that hold no finished shard are one clear line") {
  const TemporaryFolder folder;
  CHECK(Run(folder, "whole", "") == kExitOk);
  CHECK(Run(folder, "one", "1/2") == kExitOk);
  CHECK(Run(folder, "bare", "2/2") == kExitOk);
  std::filesystem::remove(folder.File("bare/estimates.h5"));
  CHECK_THROWS_WITH(Merge(folder, "out", {"one", "bare"}), Contains("bare/estimates.h5"));
  CHECK_THROWS_WITH(Merge(folder, "out", {"one", "two"}), Contains("no folder") && Contains("two"));
  CHECK_THROWS_WITH(Merge(folder, "out", {"one", "whole"}), Contains("whole' holds no finished shard"));
  CHECK_THROWS_WITH(Merge(folder, "out", {"one"}), Contains("shard 2/2 is missing"));
  CHECK_THROWS_WITH(Merge(folder, "out", {"one", "one"}), Contains("are both shard 1/2"));
  CHECK(Run(folder, "two", "2/2", true) == kExitInterrupted);
  CHECK_THROWS_WITH(Merge(folder, "out", {"one", "two"}), Contains("two (shard 2/2) was interrupted"));
  CHECK_FALSE(std::filesystem::exists(folder.File("out")));
  CHECK_THROWS_WITH(Run(folder, "two", "3/2"), Contains("--shard"));
}

}  // namespace diffsac
