#include "lab/eval/runner.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <memory>
#include <set>
#include <sstream>

#include "diffsac/core/status.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/dataset_registry.h"
#include "lab/config/yaml.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/run_files.h"
#include "lab/eval/selection.h"
#include "lab/files/files.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

using namespace testing;

std::string Csv(int threads, int batch, const std::vector<std::string>& methods = {}) {
  ExperimentOptions experiment = SmallExperiment();
  experiment.threads = threads;
  SelectEstimators(methods, &experiment);
  return WithoutTimes(RunExperiment(experiment, TwoPointInputs(batch)));
}

TEST_CASE("results don't depend on threads or batches") {
  const std::string one = Csv(1, 1);
  CHECK(Csv(2, 1) == one);
  CHECK(Csv(2, 7) == one);
  CHECK(Csv(1, 64) == one);
}

TEST_CASE("a row's results don't depend on the other rows") {
  const std::string all = Csv(2, 1), alone = Csv(2, 1, {"first"});
  std::istringstream lines(alone);
  std::string line;
  while (std::getline(lines, line)) CHECK(all.find(line) != std::string::npos);
  CHECK(alone.find(",second,") == std::string::npos);
}

/// Thousands of problems; how many of them were loaded and not estimated yet, at most.
std::atomic<int> g_waiting{0}, g_most_waiting{0};

class ManyLines : public Dataset {
 public:
  ManyLines() : lines_(MakeDataset(ConfigFromYaml("{type: synthetic_line, num_points: 30, split: test}"), 1)) {}
  Task task() const override { return Task::kLine; }
  std::int64_t size() const override { return 3000; }
  Example Get(std::uint64_t index) const override {
    const int waiting = ++g_waiting;
    for (int most = g_most_waiting; waiting > most && !g_most_waiting.compare_exchange_weak(most, waiting);) {
    }
    return lines_->Get(index);
  }

 private:
  std::unique_ptr<Dataset> lines_;
};

struct ManyLinesOptions {
  void Bind(OptionsBinder&) {}
};

const RegisteredDataset<ManyLinesOptions> kManyLines("many_lines", DataSource::kFiles, "Lines that are counted.",
                                                     [](const ManyLinesOptions&, std::uint64_t) {
                                                       return std::make_unique<ManyLines>();
                                                     });

class WaitedFor : public TwoPointEstimator {
 public:
  using TwoPointEstimator::TwoPointEstimator;
  diffsac::Estimate DoRun(const NormalizedProblem& problem, std::uint64_t seed) const override {
    --g_waiting;
    return TwoPointEstimator::DoRun(problem, seed);
  }
};

TEST_CASE("problems are loaded as they are needed (all of a condition were in memory at once)") {
  ExperimentOptions experiment = SmallExperiment();
  experiment.problems = 3000;
  experiment.conditions.resize(1);
  experiment.conditions[0].data = ConfigFromYaml("{type: many_lines}");
  SelectEstimators({"first"}, &experiment);
  const auto run = [&](int batch, int problems) {
    g_waiting = g_most_waiting = 0;
    experiment.problems = problems;
    RunInputs inputs = TwoPointInputs();
    inputs.make_row = [batch](const Config&, Task) { return std::make_unique<WaitedFor>(batch); };
    return RunExperiment(experiment, inputs);
  };
  const ExperimentResults all = run(1, 3000);
  CHECK(g_most_waiting <= 300);
  const Cell& cell = *FindCell(all, 0, 0);
  REQUIRE(cell.records.size() == 3000);
  // Which problems come together changes nothing: not with batches that no power of two holds, nor in one piece.
  const ExperimentResults in_batches = run(7, 3000), first = run(1, 200);
  CHECK(g_most_waiting <= 300);
  REQUIRE(FindCell(in_batches, 0, 0)->records.size() == 3000);
  for (std::size_t i = 0; i < 3000; ++i) {
    REQUIRE(cell.records[i].index == i);
    REQUIRE(FindCell(in_batches, 0, 0)->records[i].error.angle_deg == cell.records[i].error.angle_deg);
    if (i < 200) REQUIRE(FindCell(first, 0, 0)->records[i].error.angle_deg == cell.records[i].error.angle_deg);
  }
  CHECK(all.examples.size() == 50);
}

TEST_CASE("rows with fewer problems get the same first ones") {
  const ExperimentResults results = RunExperiment(SmallExperiment(), TwoPointInputs());
  REQUIRE(results.cells.size() == 6);
  const Cell &first = *FindCell(results, 0, 0), &second = *FindCell(results, 0, 1), &oracle = *FindCell(results, 0, 2);
  REQUIRE(first.records.size() == 40);
  REQUIRE(second.records.size() == 10);
  for (std::size_t i = 0; i < 10; ++i) {
    CHECK(first.records[i].id == second.records[i].id);
    CHECK(first.records[i].error.angle_deg == second.records[i].error.angle_deg);
  }
  const auto angle = [](const Cell& cell) {
    std::vector<double> angles;
    for (const ProblemRecord& record : cell.records) angles.push_back(record.error.angle_deg);
    return Median(angles);
  };
  CHECK(angle(oracle) < 0.5);
  CHECK(angle(oracle) < angle(first));
  CHECK_FALSE(results.partial);
  CHECK(results.examples.size() == 80);
}

// Says .9 of every point, as a probability or as a weight that is only in proportion to one.
class SayingEstimator : public TwoPointEstimator {
 public:
  explicit SayingEstimator(bool probabilities) : probabilities_(probabilities) {}
  diffsac::Estimate DoRun(const NormalizedProblem& problem, std::uint64_t seed) const override {
    diffsac::Estimate estimate = TwoPointEstimator::DoRun(problem, seed);
    estimate.inlier_probabilities.assign(static_cast<std::size_t>(problem.points().rows()), 0.9f);
    return estimate;
  }
  bool GivesProbabilities() const override { return probabilities_; }

 private:
  bool probabilities_;
};

TEST_CASE("weights that are no probabilities have no reliability curve (ng_ransac and clnet had one)") {
  int made = 0;
  const RunInputs inputs = {
      [&made](const Config&, Task) { return std::make_unique<SayingEstimator>(made++ == 0); }, {}, nullptr};
  const ExperimentResults results = RunExperiment(SmallExperiment(), inputs);
  REQUIRE(results.reliability.size() == 2);
  for (const Reliability& one : results.reliability) {
    CHECK(one.label == "First");
    const ReliabilityBins& bins = one.scenes.at("all");
    CHECK(bins[8][0] == 40 * 30);  // .9 as a float is below .9.
    CHECK(bins[8][1] == Approx(0.9 * 40 * 30));
    CHECK(bins[8][2] == Approx((one.condition == 0 ? 0.8 : 0.5) * 40 * 30));
    CHECK(bins[3][0] == 0.0);
  }
}

TEST_CASE("what a row's network was trained on stands beside the row") {
  struct Trained : TwoPointEstimator {
    std::optional<TrainingFacts> Training() const override { return TrainingFacts{100, 2000, 3000, "line"}; }
  };
  int made = 0;
  const auto make = [&made](const Config&, Task) -> std::unique_ptr<RobustEstimator> {
    if (made++ == 1) return std::make_unique<Trained>();
    return std::make_unique<TwoPointEstimator>();
  };
  const ExperimentResults results = RunExperiment(SmallExperiment(), {make, {}, nullptr});
  REQUIRE(results.learned.size() == 1);
  CHECK(results.learned[0].method == 1);
  CHECK(results.learned[0].facts.samples == 2000);
}

TEST_CASE("another seed gives other results") {
  ExperimentOptions experiment = SmallExperiment();
  experiment.seed = 4;
  CHECK(WithoutTimes(RunExperiment(experiment, TwoPointInputs())) != Csv(1, 1));
  Example one, other;
  one.id = "1";
  other.id = "2";
  CHECK(ProblemSeed(3, one) != ProblemSeed(3, other));
  CHECK(ProblemSeed(3, one) != ProblemSeed(4, one));
}

TEST_CASE("a problem gets the same draws whatever stands in the list before it") {
  const TemporaryFolder folder;
  for (const char* scene : {"a", "b"}) {
    std::filesystem::create_directory(folder / scene);
    for (int file = 0; file < 3; ++file) {
      Rng rng = Rng(scene[0]).Fork("points", file);
      std::string text;
      for (int i = 0; i < 60; ++i)
        text += std::to_string(i) + " " + std::to_string(i < 20 ? 0.5 * i : 60.0 * rng.Uniform()) + "\n";
      WriteFileAtomically(folder / scene + "/" + scene + std::to_string(file) + ".csv", text);
    }
  }
  const auto lines_of_b = [&](const std::string& paths) {
    const ExperimentOptions experiment = ReadExperiment(
        ConfigFromYaml("{name: own, data: {type: point_sets, task: line, inlier_threshold: 0.1, paths: [" + paths +
                       "]}, methods: [{name: first, type: two_point}]}"));
    std::istringstream csv(WithoutTimes(RunExperiment(experiment, TwoPointInputs())));
    std::vector<std::string> lines;
    for (std::string line; std::getline(csv, line);)
      if (line.find(",b,") != std::string::npos) lines.push_back(line.substr(line.find(',')));
    return lines;
  };
  const std::string a = folder / "a", b = folder / "b";
  const auto alone = lines_of_b(b);
  CHECK(alone.size() == 3);
  CHECK(lines_of_b(a + ", " + b) == alone);
}

TEST_CASE("a stop leaves what was done, marked partial") {
  std::atomic<bool> stop{false};
  ExperimentOptions experiment = SmallExperiment();
  experiment.threads = 1;
  RunInputs inputs = TwoPointInputs();
  inputs.stop = &stop;
  inputs.make_row = [&](const Config&, Task) { return std::make_unique<TwoPointEstimator>(1, &stop, 5); };
  const ExperimentResults results = RunExperiment(experiment, inputs);
  CHECK(results.partial);
  REQUIRE(results.cells.size() == 1);
  CHECK(results.cells[0].records.size() == 5);  // The warm-up is the first of the six calls.
  CHECK(RunJson(results, {}, WriteExperiment(experiment)).find("\"partial\": true") != std::string::npos);
  stop = true;
  const ExperimentResults nothing = RunExperiment(experiment, inputs);
  CHECK(nothing.cells.empty());
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

TEST_CASE("shards are parts of the problems in whole batches") {
  CHECK(ShardPositions(5, 1, {2, 2}) == std::vector<std::size_t>{1, 3});
  CHECK(ShardPositions(10, 4, {1, 2}) == std::vector<std::size_t>{0, 1, 2, 3, 8, 9});
  CHECK(ShardPositions(3, 4, {2, 2}).empty());
  CHECK(ShardFromText("2/3").index == 2);
  for (const char* text :
       {"", "2", "0/3", "4/3", "1/0", "1/-2", "-1/2", "1/2/3", "a/b", "1.5/2", "1/2 ", "/", "9999999999/9999999999"})
    CHECK_THROWS_WITH(ShardFromText(text), Catch::Contains("--shard") && Catch::Contains("1 <= i <= n"));
}

TEST_CASE("the lines of all shards are those of one run") {
  const auto lines_of = [](const Shard& shard, std::multiset<std::string>* lines, std::size_t* examples) {
    RunInputs inputs = TwoPointInputs();
    inputs.make_row = [](const Config& row, Task task) {
      return row.Text("type") == "oracle" ? MakeRow(row, task, {}) : std::make_unique<BatchSensitive>(16);
    };
    inputs.shard = shard;
    const ExperimentResults results = RunExperiment(SmallExperiment(), inputs);
    CHECK(results.problems == std::vector<std::size_t>{40, 40});
    std::istringstream csv(WithoutTimes(results));
    std::string line;
    std::getline(csv, line);
    while (std::getline(csv, line)) lines->insert(line);
    *examples += results.examples.size();
  };
  std::multiset<std::string> whole;
  std::size_t examples = 0;
  lines_of({1, 1}, &whole, &examples);
  for (const int count : {2, 3, 50}) {
    std::multiset<std::string> joined;
    std::size_t of_shards = 0;
    for (int i = 1; i <= count; ++i) lines_of({i, count}, &joined, &of_shards);
    CHECK(joined == whole);
    CHECK(of_shards >= examples);  // The oracle has other batches: both shards have some examples.
  }
}

TEST_CASE("data of another task is an error") {
  ExperimentOptions experiment = SmallExperiment();
  experiment.task = Task::kPlane;
  CHECK_THROWS_AS(RunExperiment(experiment, TwoPointInputs()), Error);
}

TEST_CASE("conditions of a row limit where it runs") {
  ExperimentOptions experiment = SmallExperiment();
  experiment.methods[0].conditions = {"0.5"};
  const ExperimentResults results = RunExperiment(experiment, TwoPointInputs());
  CHECK(FindCell(results, 0, 0) == nullptr);
  CHECK(FindCell(results, 1, 0) != nullptr);
}

}  // namespace
}  // namespace diffsac
