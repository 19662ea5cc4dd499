#include "lab/eval/runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <optional>
#include <set>
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
#include "lab/config/run_directory.h"
#include "lab/data/pair_check.h"
#include "lab/data/point_files.h"
#include "lab/eval/digest.h"
#include "lab/eval/instances_error.h"
#include "lab/eval/merge.h"
#include "lab/eval/problem_quantities.h"
#include "lab/ground_truth/pose_error.h"

namespace diffsac {
namespace {

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

ProblemRecord MakeRecord(const ExperimentOptions& experiment, const Example& example, const Estimate& estimate) {
  ProblemRecord record;
  static_cast<EstimateRecord&>(record) = RecordOf(example, estimate, experiment.estimates);
  record.scene = experiment.GroupOf(example.scene);
  record.error = MeasureError(estimate, example);
  AddPoseError(experiment.estimates ? record.pose : PoseOfEstimate(estimate, example.problem), example, &record.error);
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

/// What is kept of one problem.
struct Outcome {
  ProblemRecord record;
  Reliability of_network, of_ratio;    ///< Empty for rows that give no probabilities.
  std::optional<Estimate> shown = {};  ///< Where a picture shows it.
};

Outcome OutcomeOf(const ExperimentOptions& experiment, const TableRow& method, const Example& example,
                  const Estimate& estimate) {
  Outcome outcome{MakeRecord(experiment, example, estimate), {}, {}};
  if (!method.GivesProbabilities() || estimate.inlier_probabilities.empty()) return outcome;
  outcome.of_network.Add(estimate.inlier_probabilities, example.truth.inliers);
  const Eigen::VectorXf of_ratio = MatchPriors(example.problem).cast<float>();
  outcome.of_ratio.Add({of_ratio.data(), static_cast<std::size_t>(of_ratio.size())}, example.truth.inliers);
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
  const std::vector<std::size_t>& shown;  // Ascending positions of the problems whose estimates pictures show.

  bool Shows(std::size_t position) const { return std::binary_search(shown.begin(), shown.end(), position); }
  Estimate EstimateOne(const Example& example) const {
    return method.Run(
        example, {condition.name, static_cast<std::uint64_t>(experiment.seed), ProblemSeed(experiment.seed, example)});
  }
};

/// Side by side, or, where the row prefers that, batch after batch.
std::vector<Outcome> RunAll(const CellRun& run, const std::vector<std::size_t>& positions) {
  std::vector<Outcome> outcomes(positions.size());
  const auto take = [&](std::size_t i, Estimate estimate) {
    outcomes[i] = OutcomeOf(run.experiment, run.method, run.examples[positions[i]], estimate);
    if (run.Shows(positions[i])) outcomes[i].shown = std::move(estimate);
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
    std::vector<Estimate> estimates = run.method.estimator()->RunBatch(problems, seeds);
    for (std::size_t i = first; i < last; ++i) take(i, std::move(estimates[i - first]));
    run.progress.Advance(static_cast<std::int64_t>(last - first));
  }
  return outcomes;
}

/// What is kept of one row on one condition.
struct CellResults {
  std::vector<std::size_t> positions;  ///< All that are run, ascending.
  Cell cell;
  ReliabilityCurve of_network, of_ratio;
  std::map<std::size_t, Estimate> shown = {};  ///< By position.
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
    if (outcome.shown) results->shown.emplace(positions[i], std::move(*outcome.shown));
    const std::string& scene = outcome.record.scene;
    if (!outcome.of_network.empty()) results->of_network.scenes[scene].Add(outcome.of_network);
    if (!outcome.of_ratio.empty()) results->of_ratio.scenes[scene].Add(outcome.of_ratio);
    results->cell.records.push_back(std::move(outcome.record));
  }
}

// Those of the block: as they were estimated, or now where the row runs on other problems.
void KeepFits(const CellRun& run, std::size_t condition, std::size_t method, CellResults* row,
              std::vector<KeptFit>* fits) {
  for (const std::size_t i : PositionsIn(run.examples, run.shown)) {
    if (Stopped(run.inputs)) return;
    const auto known = row->shown.extract(i);
    fits->push_back({condition, run.examples[i], known ? known.mapped() : run.EstimateOne(run.examples[i]), method});
  }
}

// Of the condition's first problem.
void KeepTrace(const CellRun& run, const std::string& label, ExperimentResults* results) {
  if (run.examples.first != 0 || run.examples.examples.empty()) return;
  if (!run.inputs.trace || !results->traces.empty() || Stopped(run.inputs)) return;
  const Example& example = run.examples[0];
  auto trace = run.inputs.trace(*run.method.estimator(), example.problem, ProblemSeed(run.experiment.seed, example));
  if (trace.has_value()) results->traces.push_back({example, std::move(*trace), label});
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

// A group without a scene is most likely a misspelt name, but data that is not here may have it.
void WarnOfEmptyGroups(const ExperimentOptions& experiment, const std::set<std::string>& groups) {
  if (groups.empty()) return;
  for (const auto& entry : experiment.scene_groups)
    if (groups.count(entry.first) == 0) LogWarning("scene_groups: no scene of the data is in '" + entry.first + "'");
}

// The row whose fits are shown: the named one, or the first that is not the oracle; -1 for none.
int FitsRow(const ExperimentOptions& experiment) {
  for (std::size_t i = 0; i < experiment.methods.size(); ++i) {
    const std::string& asked = experiment.figures.qualitative_method;
    const bool fits = asked.empty() ? experiment.methods[i].type != "oracle" : experiment.methods[i].name == asked;
    if (fits) return static_cast<int>(i);
  }
  return -1;
}

// The rows whose fits are shown: one for lines and planes, several for two views.
std::vector<std::size_t> FitsRows(const ExperimentOptions& experiment) {
  constexpr std::size_t kRows = 3;
  const FigureOptions& figures = experiment.figures;
  const bool one = !IsTwoView(experiment.task) || !figures.qualitative_method.empty();
  std::vector<std::size_t> rows;
  if (one && figures.qualitative_methods.empty()) {
    const int row = FitsRow(experiment);
    if (row >= 0) rows.push_back(row);
    return rows;
  }
  for (const std::string& name : figures.qualitative_methods) rows.push_back(experiment.RowOf(name));
  for (std::size_t m = 0; figures.qualitative_methods.empty() && m < experiment.methods.size(); ++m)
    if (experiment.methods[m].type != "oracle" && rows.size() < kRows) rows.push_back(m);
  return rows;
}

// Whether fits of a condition are shown: up to four conditions, evenly spread, or the named ones.
bool ShowsFits(const ExperimentOptions& experiment, std::size_t condition) {
  const auto& named = experiment.figures.qualitative_conditions;
  const auto& all = experiment.conditions;
  if (!named.empty()) return std::find(named.begin(), named.end(), all[condition].name) != named.end();
  const std::size_t shown = std::min<std::size_t>(4, all.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const std::size_t at = shown == 1 ? 0 : i * (all.size() - 1) / (shown - 1);
    if (at == condition) return true;
  }
  return false;
}

// Whether the denoised confidences of a condition's first problem are shown: the middle condition or the named one.
bool ShowsTrace(const ExperimentOptions& experiment, std::size_t condition) {
  const std::string& named = experiment.figures.confidence_condition;
  return named.empty() ? condition == experiment.conditions.size() / 2 : experiment.conditions[condition].name == named;
}

// Which of a condition's problems are shown: the first ones; of two views, whose data comes scene by scene, evenly
// spread ones. Ascending.
std::vector<std::size_t> FitPositions(const ExperimentOptions& experiment, std::size_t problems) {
  const std::size_t count = std::min<std::size_t>(experiment.figures.qualitative, problems);
  const bool spread = IsTwoView(experiment.task);
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < count; ++i) positions.push_back(spread ? i * problems / count : i);
  return positions;
}

const std::vector<std::size_t> kNone;

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
        fit_positions_(FitPositions(experiment, problems_)),
        rows_(methods.size()),
        fits_(methods.size()) {
    const bool pictures = inputs.shard.index == 1;  // Pictures of examples are the first shard's.
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const EstimatorRow& row = experiment.methods[m];
      rows_[m] = {{}, {condition, m, {}}, {row.label, condition, {}}, {kRatioLabel, condition, {}}};
      if (row.RunsOn(experiment.conditions[condition].name))
        rows_[m].positions = RowPositions(row, methods[m], problems_, inputs.shard);
      Need(rows_[m].positions);
    }
    if (pictures) Need(fit_positions_);
    shows_trace_ = pictures && ShowsTrace(experiment, condition);
    if (pictures && ShowsFits(experiment, condition)) fits_rows_ = FitsRows(experiment);
  }

  void Run(Progress& progress, Digest* data, ExperimentResults* results) {
    const std::size_t size = BlockSize(methods_, problems_);
    std::set<std::string> groups;
    for (std::size_t first = 0; first < problems_ && !Stopped(inputs_); first += size) {
      const Block block = Load(first, std::min(first + size, problems_));
      for (const Example& example : block.examples) {
        groups.insert(experiment_.GroupOf(example.scene));
        AddPoints(example.problem.points, data);
      }
      for (std::size_t m = 0; m < methods_.size(); ++m) RunRow(block, m, progress, results);
    }
    results->problems.push_back(problems_);
    if (condition_ == 0 && inputs_.shard.whole() && !Stopped(inputs_)) WarnOfEmptyGroups(experiment_, groups);
    for (std::size_t m = 0; m < methods_.size(); ++m) Keep(m, results);
  }

 private:
  void Need(const std::vector<std::size_t>& positions) {
    for (const std::size_t i : positions) needed_[i] = 1;
  }

  Block Load(std::size_t first, std::size_t end) const {
    Block block{first, std::vector<Example>(end - first)};
    ParallelFor(static_cast<std::int64_t>(end - first), experiment_.threads, [&](std::int64_t i) {
      if (needed_[first + i] != 0) block.examples[i] = dataset_.Get(static_cast<std::int64_t>(first) + i);
    });
    return block;
  }

  void RunRow(const Block& block, std::size_t m, Progress& progress, ExperimentResults* results) {
    const EstimatorRow& row = experiment_.methods[m];
    if (!row.RunsOn(experiment_.conditions[condition_].name) || Stopped(inputs_)) return;
    const bool shows_fits = std::find(fits_rows_.begin(), fits_rows_.end(), m) != fits_rows_.end();
    const CellRun run{experiment_,
                      inputs_,
                      block,
                      experiment_.conditions[condition_],
                      methods_[m],
                      progress,
                      shows_fits ? fit_positions_ : kNone};
    RunBlock(run, &rows_[m]);
    if (shows_fits) KeepFits(run, condition_, m, &rows_[m], &fits_[m]);
    if (run.method.estimator() != nullptr && shows_trace_) KeepTrace(run, row.label, results);
  }

  void Keep(std::size_t m, ExperimentResults* results) {
    CellResults& row = rows_[m];
    for (ReliabilityCurve* curve : {&row.of_network, &row.of_ratio})
      if (!curve->scenes.empty()) results->reliability.push_back(std::move(*curve));
    const auto* sources = dynamic_cast<const HasPointSources*>(&dataset_);
    for (ProblemRecord& record : row.cell.records)
      if (sources != nullptr && experiment_.estimates) record.rows = sources->SourceOf(record.index).rows;
    if (!row.cell.records.empty()) results->cells.push_back(std::move(row.cell));
    for (KeptFit& fit : fits_[m]) {
      if (IsTwoView(experiment_.task)) fit.folder = dataset_.FolderOf(fit.example.scene);
      results->fits.push_back(std::move(fit));
    }
  }

  const ExperimentOptions& experiment_;
  const RunInputs& inputs_;
  const std::size_t condition_;
  const Dataset& dataset_;
  const Rows& methods_;
  const std::size_t problems_;
  std::vector<char> needed_;  // By problem: whether a row or a picture takes it.
  const std::vector<std::size_t> fit_positions_;
  std::vector<CellResults> rows_;
  std::vector<std::vector<KeptFit>> fits_;
  std::vector<std::size_t> fits_rows_;
  bool shows_trace_ = false;
};

}  // namespace

std::uint64_t ProblemSeed(std::uint64_t experiment_seed, const Example& problem) {
  return Rng(experiment_seed).Fork("estimate").Fork(problem.scene + "/" + problem.id).Seed();
}

ExperimentResults RunExperiment(const ExperimentOptions& experiment, const RunInputs& inputs) {
  const auto start = std::chrono::steady_clock::now();
  ExperimentResults results;
  results.experiment = experiment;
  results.shard = inputs.shard;
  results.git_revision = GitRevision();
  results.machine = MachineText();
  const auto datasets = MakeDatasets(experiment);
  for (const auto& dataset : datasets) WarnOfMissingTruth(*dataset);
  const Rows methods = MakeRows(experiment, inputs.make_row);
  const Config& data = experiment.conditions.front().data;
  if (data.Has("type")) results.dataset = data.Text("type");
  for (std::size_t m = 0; m < methods.size(); ++m)
    if (const auto facts = methods[m].Training()) results.learned.push_back({m, *facts});
  const int fits_row = FitsRow(experiment);
  if (fits_row >= 0) results.fits_label = experiment.methods[fits_row].label;
  Progress progress(experiment.name, TotalWork(experiment, datasets, methods, inputs.shard));
  Digest points;
  for (std::size_t c = 0; c < datasets.size() && !Stopped(inputs); ++c)
    ConditionRun(experiment, inputs, c, *datasets[c], methods).Run(progress, &points, &results);
  progress.Finish();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  results.facts = {elapsed.count(), PeakMemoryMib(), inputs.shard.whole() ? points.Hex() : "", NetworksOf(experiment)};
  results.partial = Stopped(inputs);
  return results;
}

}  // namespace diffsac
