#include "lab/eval/runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string_view>

#include "diffsac/core/embedded_models.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/random.h"
#include "diffsac/estimate/diagnose.h"
#include "diffsac/estimate/estimation_priors.h"
#include "diffsac/problem/match_probabilities.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/paths.h"
#include "lab/config/process.h"
#include "lab/config/progress.h"
#include "lab/data/pair_check.h"
#include "lab/eval/digest.h"
#include "lab/eval/kept_examples.h"
#include "lab/eval/problem_quantities.h"
#include "lab/ground_truth/instances_error.h"
#include "lab/ground_truth/task_truth.h"

namespace diffsac {
namespace {

/// The label of the reliability of the probabilities by the matching ratio, on the problems of a row with a network.
constexpr const char* kRatioLabel = "by the matching ratio";

bool Stopped(const RunInputs& inputs) { return inputs.stop != nullptr && inputs.stop->load(); }

std::vector<std::unique_ptr<Dataset>> MakeDatasets(const ExperimentOptions& experiment) {
  std::vector<std::unique_ptr<Dataset>> datasets;
  for (const Condition& condition : experiment.conditions) {
    datasets.push_back(MakeDataset(condition.data, experiment.seed));
    if (datasets.back()->task() != experiment.task)
      throw Error("condition '" + condition.name + "': its data is for task '" + ToString(datasets.back()->task()) +
                  "', the experiment for '" + ToString(experiment.task) + "'");
  }
  return datasets;
}

using Rows = std::vector<TableRow>;

Rows MakeRows(const ExperimentOptions& experiment, const RowFactory& make) {
  Rows rows;
  for (const EstimatorRow& row : experiment.methods) rows.push_back(make(row.config, experiment.task));
  return rows;
}

std::size_t ProblemCount(const Dataset& dataset, const ExperimentOptions& experiment) {
  const std::int64_t count = experiment.problems;
  return static_cast<std::size_t>(dataset.size() < 0 ? count : std::min(count, dataset.size()));
}

// The problems of one row on one condition that are this shard's.
std::vector<std::size_t> RowPositions(const EstimatorRow& row, const TableRow& method, std::size_t problems,
                                      const Shard& shard) {
  if (row.max_problems > 0) problems = std::min(problems, static_cast<std::size_t>(row.max_problems));
  return ShardPositions(problems, static_cast<std::size_t>(method.PreferredBatch()), shard);
}

double ShareOfTrueSets(const Estimate& estimate, const std::vector<std::uint8_t>& inliers) {
  if (estimate.minimal_sets.empty() || inliers.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto pure = std::count_if(estimate.minimal_sets.begin(), estimate.minimal_sets.end(), [&](const auto& set) {
    return std::all_of(set.begin(), set.end(), [&](int i) { return inliers[i] != 0; });
  });
  return static_cast<double>(pure) / static_cast<double>(estimate.minimal_sets.size());
}

void RecordInstances(const Example& example, const Estimate& estimate, ProblemRecord* record) {
  if (std::isnan(record->error.recall)) return;
  const InstanceShares shares = InstanceSharesOf(estimate.minimal_sets, example.truth);
  record->one_instance_sets = shares.one_instance;
  record->instances_in_sets = shares.instances;
  record->instance_count = static_cast<int>(InstancesOf(estimate, example.problem).models.size());
}

}  // namespace

ProblemRecord MakeRecord(const ExperimentOptions& experiment, const Example& example, const Estimate& estimate,
                         bool whole) {
  ProblemRecord record;
  static_cast<EstimateRecord&>(record) = RecordOf(example, estimate, whole);
  record.error = MeasureError(estimate, example);
  AddPoseError(whole ? record.pose : PoseOfEstimate(estimate, example.problem), example, &record.error);
  record.has_ambiguous_pose = estimate.ambiguous_pose.has_value();
  record.error_probability = estimate.error_probability;
  record.inliers = static_cast<int>(std::count(estimate.inliers.begin(), estimate.inliers.end(), 1));
  record.all_inlier_sets = ShareOfTrueSets(estimate, example.truth.inliers);
  RecordInstances(example, estimate, &record);
  RecordQuantities(example, experiment.share_within_px, &record);
  record.levels = PoseLevelsOf(estimate, example);
  record.stats = estimate.stats;
  record.done = true;
  return record;
}

namespace {

/// One problem: probabilities in [0, 1], and for each point whether it is a true inlier. Nothing where the lengths
/// differ (no truth, or no probabilities).
std::optional<ReliabilityBins> CountReliability(std::span<const float> probabilities,
                                                const std::vector<std::uint8_t>& inliers) {
  if (probabilities.empty() || probabilities.size() != inliers.size()) return std::nullopt;
  ReliabilityBins bins{};
  const auto last = static_cast<int>(bins.size()) - 1;
  for (std::size_t i = 0; i < inliers.size(); ++i) {
    const double p = probabilities[i];
    if (!(p >= 0.0 && p <= 1.0)) continue;
    auto& [points, predicted, true_inliers] =
        bins[static_cast<std::size_t>(std::min(last, static_cast<int>(p * static_cast<double>(bins.size()))))];
    points += 1.0;
    predicted += p;
    true_inliers += inliers[i] != 0 ? 1.0 : 0.0;
  }
  return bins;
}

void Add(const std::optional<ReliabilityBins>& bins, const std::string& scene, Reliability* all) {
  if (!bins) return;
  ReliabilityBins& sums = all->scenes[scene];
  for (std::size_t b = 0; b < sums.size(); ++b)
    for (std::size_t k = 0; k < sums[b].size(); ++k) sums[b][k] += (*bins)[b][k];
}

/// What is kept of one problem.
struct Outcome {
  ProblemRecord record;
  std::optional<ReliabilityBins> of_network, of_ratio;  ///< Nothing for rows that give no probabilities.
};

Outcome OutcomeOf(const ExperimentOptions& experiment, const TableRow& method, const Example& example,
                  const Estimate& estimate, bool whole) {
  Outcome outcome{MakeRecord(experiment, example, estimate, whole), {}, {}};
  if (!method.GivesProbabilities() || estimate.inlier_probabilities.empty()) return outcome;
  outcome.of_network = CountReliability(estimate.inlier_probabilities, example.truth.inliers);
  const Eigen::VectorXf of_ratio = MatchPriors(example.problem).cast<float>();
  outcome.of_ratio =
      CountReliability({of_ratio.data(), static_cast<std::size_t>(of_ratio.size())}, example.truth.inliers);
  return outcome;
}

/// Following problems of a condition: loaded together, estimated by every row, and let go before the next ones, so that
/// data does not grow with the number of problems.
struct Block {
  std::size_t first = 0;
  std::vector<Example> examples;  ///< Those that no row needs are empty.

  std::size_t end() const { return first + examples.size(); }
  const Example& operator[](std::size_t position) const { return examples[position - first]; }
};

/// Everything that the loop over a block's problems needs.
struct CellRun {
  const ExperimentOptions& experiment;
  const RunInputs& inputs;
  const Block& examples;
  const Condition& condition;
  const TableRow& method;
  Progress& progress;
  const std::vector<std::size_t>& kept;  // Ascending positions of the examples.

  bool KeepsEstimate(std::size_t position) const {
    return experiment.estimates || std::binary_search(kept.begin(), kept.end(), position);
  }
  Estimate EstimateOne(const Example& example) const {
    return method.Run(
        example, {condition.name, static_cast<std::uint64_t>(experiment.seed), ProblemSeed(experiment.seed, example)});
  }
};

/// Side by side, or, where the row prefers that, batch after batch.
std::vector<Outcome> RunAll(const CellRun& run, const std::vector<std::size_t>& positions) {
  std::vector<Outcome> outcomes(positions.size());
  const auto take = [&](std::size_t i, const Estimate& estimate) {
    outcomes[i] =
        OutcomeOf(run.experiment, run.method, run.examples[positions[i]], estimate, run.KeepsEstimate(positions[i]));
  };
  const auto batch = static_cast<std::size_t>(run.method.PreferredBatch());
  if (batch <= 1)
    ParallelFor(static_cast<std::int64_t>(positions.size()), run.experiment.threads, [&](std::int64_t i) {
      if (Stopped(run.inputs)) return;
      take(i, run.EstimateOne(run.examples[positions[i]]));
      run.progress.Advance();
    });
  for (std::size_t first = 0; batch > 1 && first < positions.size() && !Stopped(run.inputs); first += batch) {
    const std::size_t last = std::min(first + batch, positions.size());
    std::vector<const Problem*> problems;
    std::vector<std::uint64_t> seeds;
    for (std::size_t i = first; i < last; ++i) {
      const Example& example = run.examples[positions[i]];
      problems.push_back(&example.problem);
      seeds.push_back(ProblemSeed(run.experiment.seed, example));
    }
    const std::vector<Estimate> estimates = run.method.estimator()->RunBatch(problems, seeds);
    for (std::size_t i = first; i < last; ++i) take(i, estimates[i - first]);
    run.progress.Advance(static_cast<std::int64_t>(last - first));
  }
  return outcomes;
}

/// What is kept of one row on one condition.
struct CellResults {
  std::vector<std::size_t> positions;  ///< All that are run, ascending.
  Cell cell;
  Reliability of_network, of_ratio;
};

// The part of ascending positions that lies in the block.
std::vector<std::size_t> PositionsIn(const Block& block, const std::vector<std::size_t>& positions) {
  return {std::lower_bound(positions.begin(), positions.end(), block.first),
          std::lower_bound(positions.begin(), positions.end(), block.end())};
}

void RunBlock(const CellRun& run, CellResults* results) {
  const std::vector<std::size_t> positions = PositionsIn(run.examples, results->positions);
  if (positions.empty() || Stopped(run.inputs)) return;
  // Caches, allocators and networks are slow the first time: that is not part of a method's milliseconds.
  if (positions.front() == results->positions.front()) run.EstimateOne(run.examples[positions.front()]);
  std::vector<Outcome> outcomes = RunAll(run, positions);
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    Outcome& outcome = outcomes[i];
    if (!outcome.record.done) continue;
    Add(outcome.of_network, outcome.record.scene, &results->of_network);
    Add(outcome.of_ratio, outcome.record.scene, &results->of_ratio);
    results->cell.records.push_back(std::move(outcome.record));
  }
}

std::int64_t TotalWork(const ExperimentOptions& experiment, const std::vector<std::unique_ptr<Dataset>>& datasets,
                       const Rows& methods, const Shard& shard) {
  std::size_t total = 0;
  for (std::size_t c = 0; c < datasets.size(); ++c) {
    const std::size_t problems = ProblemCount(*datasets[c], experiment);
    for (std::size_t m = 0; m < methods.size(); ++m)
      if (experiment.methods[m].RunsOn(experiment.conditions[c].name))
        total += RowPositions(experiment.methods[m], methods[m], problems, shard).size();
  }
  return static_cast<std::int64_t>(total);
}

// Small, as a problem may have very many points. A whole number of every row's batches, which see the same problems
// together whatever the block.
std::size_t BlockSize(const Rows& methods, std::size_t problems) {
  constexpr std::size_t kProblems = 256;
  std::size_t size = 1;
  for (const TableRow& method : methods) {
    size = std::lcm(size, static_cast<std::size_t>(method.PreferredBatch()));
    if (size >= problems) return problems;
  }
  return size * ((kProblems + size - 1) / size);
}

void AddPoints(const Eigen::MatrixXd& points, Digest* data) {
  data->Add(points.data(), static_cast<std::size_t>(points.size()) * sizeof(double));
}

// "models/line/model.safetensors", wherever these folders are.
std::string EndOf(const std::string& path) {
  const std::filesystem::path file(path), folder = file.parent_path();
  return (folder.parent_path().filename() / folder.filename() / file.filename()).string();
}

std::vector<std::pair<std::string, std::string>> NetworksOf(const ExperimentOptions& experiment) {
  std::vector<std::pair<std::string, std::string>> networks;
  std::set<std::string> known;
  for (const EstimatorRow& row : experiment.methods) {
    const std::string path = row.config.Has("checkpoint") ? row.config.Text("checkpoint") : "";
    if (path.empty() || !known.insert(path).second) continue;
    const std::string found = RequiredPath(row.config.Sub("checkpoint"), "checkpoint");
    const std::string_view embedded = EmbeddedModel(found);
    if (embedded.empty())
      networks.emplace_back(EndOf(found), DigestOfFile(found));
    else
      networks.emplace_back(path, DigestOfText(std::string(embedded)));
  }
  return networks;
}

/// All rows on one condition.
class ConditionRun {
 public:
  ConditionRun(const ExperimentOptions& experiment, const RunInputs& inputs, std::size_t condition,
               const Dataset& dataset, const Rows& methods)
      : experiment_(experiment),
        inputs_(inputs),
        condition_(condition),
        dataset_(dataset),
        methods_(methods),
        problems_(ProblemCount(dataset, experiment)),
        needed_(problems_, 0),
        kept_(ExamplePositions(experiment, problems_)),
        rows_(methods.size()) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const EstimatorRow& row = experiment.methods[m];
      rows_[m] = {{}, {condition, m, {}}, {row.label, condition, {}}, {kRatioLabel, condition, {}}};
      if (row.RunsOn(experiment.conditions[condition].name))
        rows_[m].positions = RowPositions(row, methods[m], problems_, inputs.shard);
      for (const std::size_t i : rows_[m].positions) needed_[i] = 1;
    }
    std::erase_if(kept_, [&](std::size_t i) { return needed_[i] == 0; });  // Another shard's.
  }

  void Run(Progress& progress, Digest* data, ExampleKeeper* keeper, ExperimentResults* results) {
    const std::size_t size = BlockSize(methods_, problems_);
    for (std::size_t first = 0; first < problems_ && !Stopped(inputs_); first += size) {
      const Block block = Load(first, std::min(first + size, problems_));
      for (const Example& example : block.examples) AddPoints(example.problem.points, data);
      for (std::size_t m = 0; m < methods_.size(); ++m) RunRow(block, m, progress);
      for (const std::size_t i : PositionsIn(block, kept_)) keeper->Keep(condition_, block[i], dataset_);
      if (first == 0 && !kept_.empty() && kept_.front() == 0) KeepTrace(block[0], results);
    }
    results->problems.push_back(problems_);
    for (CellResults& row : rows_) Keep(&row, results);
  }

 private:
  Block Load(std::size_t first, std::size_t end) const {
    Block block{first, std::vector<Example>(end - first)};
    ParallelFor(static_cast<std::int64_t>(end - first), experiment_.threads, [&](std::int64_t i) {
      if (needed_[first + i] != 0) block.examples[i] = dataset_.Get(static_cast<std::int64_t>(first) + i);
    });
    return block;
  }

  void RunRow(const Block& block, std::size_t m, Progress& progress) {
    const Condition& condition = experiment_.conditions[condition_];
    if (!experiment_.methods[m].RunsOn(condition.name) || Stopped(inputs_)) return;
    RunBlock({experiment_, inputs_, block, condition, methods_[m], progress, kept_}, &rows_[m]);
  }

  void KeepTrace(const Example& example, ExperimentResults* results) const {
    for (std::size_t m = 0; m < methods_.size() && inputs_.trace && !Stopped(inputs_); ++m) {
      const RobustEstimator* estimator = methods_[m].estimator();
      if (estimator == nullptr || rows_[m].positions.empty()) continue;
      auto trace = inputs_.trace(*estimator, example.problem, ProblemSeed(experiment_.seed, example));
      if (!trace) continue;
      results->traces.push_back({condition_, m, example.index, std::move(*trace)});
      return;
    }
  }

  void Keep(CellResults* row, ExperimentResults* results) const {
    for (Reliability* one : {&row->of_network, &row->of_ratio})
      if (!one->scenes.empty()) results->reliability.push_back(std::move(*one));
    if (const auto* sources = dynamic_cast<const HasPointSources*>(&dataset_))
      for (ProblemRecord& record : row->cell.records) record.rows = sources->SourceOf(record.index).rows;
    if (!row->cell.records.empty()) results->cells.push_back(std::move(row->cell));
  }

  const ExperimentOptions& experiment_;
  const RunInputs& inputs_;
  const std::size_t condition_;
  const Dataset& dataset_;
  const Rows& methods_;
  const std::size_t problems_;
  std::vector<char> needed_;       // By problem: whether a row takes it.
  std::vector<std::size_t> kept_;  // Of the examples, those that a row takes.
  std::vector<CellResults> rows_;
};

}  // namespace

std::uint64_t ProblemSeed(std::uint64_t experiment_seed, const Example& problem) {
  return Rng(experiment_seed).Fork("estimate").Fork(problem.scene + "/" + problem.id).Seed();
}

std::vector<std::size_t> ShardPositions(std::size_t count, std::size_t batch, const Shard& shard) {
  const auto shards = static_cast<std::size_t>(shard.count), mine = static_cast<std::size_t>(shard.index - 1);
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < count; ++i)
    if (i / batch % shards == mine) positions.push_back(i);
  return positions;
}

ExperimentResults RunExperiment(const ExperimentOptions& experiment, const RunInputs& inputs) {
  const auto start = std::chrono::steady_clock::now();
  ExperimentResults results;
  results.experiment = experiment;
  results.shard = inputs.shard;
  const auto datasets = MakeDatasets(experiment);
  for (const auto& dataset : datasets) WarnOfMissingTruth(*dataset);
  const Rows methods = MakeRows(experiment, inputs.make_row);
  const Config& data = experiment.conditions.front().data;
  if (data.Has("type")) results.dataset = data.Text("type");
  for (std::size_t m = 0; m < methods.size(); ++m)
    if (const auto facts = methods[m].Training()) results.learned.push_back({m, *facts});
  Progress progress(experiment.name, TotalWork(experiment, datasets, methods, inputs.shard));
  Digest points;
  ExampleKeeper keeper(&results.examples);
  for (std::size_t c = 0; c < datasets.size() && !Stopped(inputs); ++c)
    ConditionRun(experiment, inputs, c, *datasets[c], methods).Run(progress, &points, &keeper, &results);
  progress.Finish();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  results.facts = {elapsed.count(), PeakMemoryMib(), inputs.shard.whole() ? points.Hex() : "", NetworksOf(experiment)};
  results.partial = Stopped(inputs);
  return results;
}

}  // namespace diffsac
