#include "diffsac/eval/runner.h"

#include <algorithm>
#include <cmath>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/progress.h"
#include "diffsac/core/random.h"
#include "diffsac/core/run_directory.h"
#include "diffsac/data/dataset_factory.h"
#include "diffsac/eval/structures_error.h"
#include "diffsac/methods/known_of_problem.h"
#include "diffsac/methods/oracle.h"

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

using Methods = std::vector<std::unique_ptr<Method>>;

// Null for the oracle, which is no Method.
Methods MakeMethods(const ExperimentOptions& experiment, const MethodFactory& make) {
  Methods methods;
  for (const MethodRow& row : experiment.methods)
    methods.push_back(row.type == "oracle" ? nullptr : make(row.config, experiment.task));
  return methods;
}

std::size_t ProblemCount(const Dataset& dataset, const ExperimentOptions& experiment) {
  const std::int64_t count = experiment.problems;
  return static_cast<std::size_t>(dataset.size() < 0 ? count : std::min(count, dataset.size()));
}

// The problems of one row on one condition that are this shard's.
std::vector<std::size_t> RowPositions(const MethodRow& row, const Method* method, std::size_t problems,
                                      const Shard& shard) {
  if (row.max_problems > 0) problems = std::min(problems, static_cast<std::size_t>(row.max_problems));
  return ShardPositions(problems, method == nullptr ? 1 : static_cast<std::size_t>(method->PreferredBatch()), shard);
}

double ShareOfTrueSets(const Estimate& estimate, const std::vector<std::uint8_t>& inliers) {
  if (estimate.minimal_sets.empty() || inliers.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto pure = std::count_if(estimate.minimal_sets.begin(), estimate.minimal_sets.end(), [&](const auto& set) {
    return std::all_of(set.begin(), set.end(), [&](int i) { return inliers[i] != 0; });
  });
  return static_cast<double>(pure) / static_cast<double>(estimate.minimal_sets.size());
}

void RecordStructures(const Example& example, const Estimate& estimate, ProblemRecord* record) {
  if (std::isnan(record->error.recall)) return;
  const StructureShares shares = StructureSharesOf(estimate.minimal_sets, example.truth);
  record->one_structure_sets = shares.one_structure;
  record->structures_in_sets = shares.structures;
  record->structures = static_cast<int>(StructuresOf(estimate, example.problem).models.size());
}

ProblemRecord MakeRecord(const ExperimentOptions& experiment, const Example& example, const Estimate& estimate) {
  ProblemRecord record;
  record.index = example.index;
  record.id = example.id;
  record.scene = experiment.GroupOf(example.scene);
  record.status = estimate.status;
  record.error = MeasureError(estimate, example);
  record.points = static_cast<int>(example.problem.points.rows());
  record.inliers = static_cast<int>(std::count(estimate.inliers.begin(), estimate.inliers.end(), 1));
  record.all_inlier_sets = ShareOfTrueSets(estimate, example.truth.inliers);
  RecordStructures(example, estimate, &record);
  record.report = estimate.report;
  record.done = true;
  return record;
}

/// What is kept of one problem.
struct Outcome {
  ProblemRecord record;
  EstimateRecord estimate;
  Reliability of_network, of_ratio;  ///< Empty for rows that give no probabilities.
};

Outcome OutcomeOf(const ExperimentOptions& experiment, const Method* method, const Example& example,
                  const Estimate& estimate) {
  Outcome outcome{MakeRecord(experiment, example, estimate),
                  experiment.estimates ? RecordOf(example, estimate) : EstimateRecord{},
                  {},
                  {}};
  if (method == nullptr || !method->GivesProbabilities() || estimate.inlier_probabilities.empty()) return outcome;
  outcome.of_network.Add(estimate.inlier_probabilities, example.truth.inliers);
  const Eigen::VectorXf of_ratio = example.problem.quality.unaryExpr(&InlierProbabilityOfRatio).cast<float>();
  outcome.of_ratio.Add({of_ratio.data(), static_cast<std::size_t>(of_ratio.size())}, example.truth.inliers);
  return outcome;
}

/// Everything that one cell's loop needs.
struct CellRun {
  const ExperimentOptions& experiment;
  const RunInputs& inputs;
  const std::vector<Example>& examples;  // Of all problems; those that are not needed are empty.
  const Method* method;                  // null: the oracle
  Progress& progress;

  Estimate EstimateOne(const Example& example) const {
    if (method == nullptr) return OracleEstimate(example.problem, example.truth);
    return method->Estimate(example.problem, ProblemSeed(experiment.seed, example.index));
  }
};

void RunOneByOne(const CellRun& run, const std::vector<std::size_t>& positions, std::vector<Outcome>* outcomes) {
  ParallelFor(static_cast<std::int64_t>(outcomes->size()), run.experiment.threads, [&](std::int64_t i) {
    if (Stopped(run.inputs)) return;
    const Example& example = run.examples[positions[i]];
    (*outcomes)[i] = OutcomeOf(run.experiment, run.method, example, run.EstimateOne(example));
    run.progress.Advance();
  });
}

void RunInBatches(const CellRun& run, const std::vector<std::size_t>& positions, std::vector<Outcome>* outcomes) {
  const auto batch = static_cast<std::size_t>(run.method->PreferredBatch());
  for (std::size_t first = 0; first < outcomes->size() && !Stopped(run.inputs); first += batch) {
    const std::size_t last = std::min(first + batch, outcomes->size());
    std::vector<const Problem*> problems;
    std::vector<std::uint64_t> seeds;
    for (std::size_t i = first; i < last; ++i) {
      const Example& example = run.examples[positions[i]];
      problems.push_back(&example.problem);
      seeds.push_back(ProblemSeed(run.experiment.seed, example.index));
    }
    const std::vector<Estimate> estimates = run.method->EstimateBatch(problems, seeds);
    for (std::size_t i = first; i < last; ++i)
      (*outcomes)[i] = OutcomeOf(run.experiment, run.method, run.examples[positions[i]], estimates[i - first]);
    run.progress.Advance(static_cast<std::int64_t>(last - first));
  }
}

void RunCell(const CellRun& run, const std::vector<std::size_t>& positions, Cell* cell, ReliabilityCurve* of_network,
             ReliabilityCurve* of_ratio) {
  std::vector<Outcome> outcomes(positions.size());
  // Caches, allocators and networks are slow the first time: that is not part of a method's milliseconds.
  if (!positions.empty() && !Stopped(run.inputs)) run.EstimateOne(run.examples[positions.front()]);
  if (run.method != nullptr && run.method->PreferredBatch() > 1) {
    RunInBatches(run, positions, &outcomes);
  } else {
    RunOneByOne(run, positions, &outcomes);
  }
  for (Outcome& outcome : outcomes) {
    if (!outcome.record.done) continue;
    const std::string& scene = outcome.record.scene;
    if (!outcome.of_network.empty()) of_network->scenes[scene].Add(outcome.of_network);
    if (!outcome.of_ratio.empty()) of_ratio->scenes[scene].Add(outcome.of_ratio);
    cell->records.push_back(std::move(outcome.record));
    if (run.experiment.estimates) cell->estimates.push_back(std::move(outcome.estimate));
  }
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

// Up to four conditions, evenly spread, or the named ones.
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

bool ShowsTrace(const ExperimentOptions& experiment, std::size_t condition) {
  const std::string& named = experiment.figures.confidence_condition;
  return named.empty() ? condition == experiment.conditions.size() / 2 : experiment.conditions[condition].name == named;
}

// The first problems; of two views, whose data comes scene by scene, evenly spread ones.
std::vector<std::size_t> FitPositions(const ExperimentOptions& experiment, std::size_t problems) {
  const std::size_t count = std::min<std::size_t>(experiment.figures.qualitative, problems);
  const bool spread = IsTwoView(experiment.task);
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < count; ++i) positions.push_back(spread ? i * problems / count : i);
  return positions;
}

void KeepFits(const CellRun& run, std::size_t condition, std::size_t method, ExperimentResults* results) {
  for (const std::size_t i : FitPositions(run.experiment, run.examples.size())) {
    if (Stopped(run.inputs)) return;
    results->fits.push_back({condition, run.examples[i], run.EstimateOne(run.examples[i]), method});
  }
}

void KeepTrace(const CellRun& run, const std::string& label, ExperimentResults* results) {
  if (!run.inputs.trace || !results->traces.empty() || run.examples.empty() || Stopped(run.inputs)) return;
  const Example& example = run.examples.front();
  auto trace = run.inputs.trace(*run.method, example.problem, ProblemSeed(run.experiment.seed, example.index));
  if (trace.has_value()) results->traces.push_back({example, std::move(*trace), label});
}

std::int64_t TotalWork(const ExperimentOptions& experiment, const std::vector<std::unique_ptr<Dataset>>& datasets,
                       const Methods& methods, const Shard& shard) {
  std::size_t total = 0;
  for (std::size_t c = 0; c < datasets.size(); ++c) {
    const std::size_t problems = ProblemCount(*datasets[c], experiment);
    for (std::size_t m = 0; m < methods.size(); ++m)
      if (experiment.methods[m].RunsOn(experiment.conditions[c].name))
        total += RowPositions(experiment.methods[m], methods[m].get(), problems, shard).size();
  }
  return static_cast<std::int64_t>(total);
}

// The examples that any row of the condition takes, and those of pictures; the others stay empty.
std::vector<Example> LoadExamples(const ExperimentOptions& experiment, std::size_t condition, const Dataset& dataset,
                                  const Methods& methods, const Shard& shard) {
  std::vector<Example> examples(ProblemCount(dataset, experiment));
  std::vector<char> needed(examples.size(), 0);
  const auto need = [&](const std::vector<std::size_t>& positions) {
    for (const std::size_t i : positions) needed[i] = 1;
  };
  for (std::size_t m = 0; m < methods.size(); ++m)
    if (experiment.methods[m].RunsOn(experiment.conditions[condition].name))
      need(RowPositions(experiment.methods[m], methods[m].get(), examples.size(), shard));
  if (shard.index == 1) need(FitPositions(experiment, examples.size()));
  ParallelFor(static_cast<std::int64_t>(examples.size()), experiment.threads, [&](std::int64_t i) {
    if (needed[i] != 0) examples[i] = dataset.Get(i);
  });
  return examples;
}

// A group without a scene is most likely a misspelt name, but data that is not here may have it.
void WarnOfEmptyGroups(const ExperimentOptions& experiment, const std::vector<Example>& examples) {
  for (const auto& entry : experiment.scene_groups) {
    const std::string& group = entry.first;
    const bool used = std::any_of(examples.begin(), examples.end(),
                                  [&](const Example& example) { return experiment.GroupOf(example.scene) == group; });
    if (!used && !examples.empty()) LogWarning("scene_groups: no scene of the data is in '" + group + "'");
  }
}

void RunCondition(const ExperimentOptions& experiment, const RunInputs& inputs, std::size_t condition,
                  const Dataset& dataset, const Methods& methods, Progress& progress, ExperimentResults* results) {
  const std::vector<Example> examples = LoadExamples(experiment, condition, dataset, methods, inputs.shard);
  results->problems.push_back(examples.size());
  if (condition == 0 && inputs.shard.whole()) WarnOfEmptyGroups(experiment, examples);
  const std::vector<std::size_t> fits_rows = FitsRows(experiment);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const MethodRow& row = experiment.methods[m];
    if (!row.RunsOn(experiment.conditions[condition].name) || Stopped(inputs)) continue;
    const CellRun run{experiment, inputs, examples, methods[m].get(), progress};
    Cell cell{condition, m, {}, {}};
    ReliabilityCurve of_network{row.label, condition, {}}, of_ratio{kRatioLabel, condition, {}};
    RunCell(run, RowPositions(row, run.method, examples.size(), inputs.shard), &cell, &of_network, &of_ratio);
    for (ReliabilityCurve* curve : {&of_network, &of_ratio})
      if (!curve->scenes.empty()) results->reliability.push_back(std::move(*curve));
    if (!cell.records.empty()) results->cells.push_back(std::move(cell));
    if (inputs.shard.index != 1) continue;  // Pictures of examples are the first shard's.
    if (std::find(fits_rows.begin(), fits_rows.end(), m) != fits_rows.end() && ShowsFits(experiment, condition))
      KeepFits(run, condition, m, results);
    if (run.method != nullptr && ShowsTrace(experiment, condition)) KeepTrace(run, row.label, results);
  }
}

}  // namespace

std::uint64_t ProblemSeed(std::uint64_t experiment_seed, std::uint64_t problem_index) {
  return Rng(experiment_seed).Fork("estimate", problem_index).Seed();
}

ExperimentResults RunExperiment(const ExperimentOptions& experiment, const RunInputs& inputs) {
  ExperimentResults results;
  results.experiment = experiment;
  results.shard = inputs.shard;
  results.git_revision = GitRevision();
  results.machine = MachineText();
  const auto datasets = MakeDatasets(experiment);
  const auto methods = MakeMethods(experiment, inputs.make_method);
  const Config& data = experiment.conditions.front().data;
  if (data.Has("type")) results.dataset = data.Text("type");
  for (std::size_t m = 0; m < methods.size(); ++m)
    if (const auto facts = methods[m] ? methods[m]->Training() : std::nullopt) results.learned.push_back({m, *facts});
  const int fits_row = FitsRow(experiment);
  if (fits_row >= 0) results.fits_label = experiment.methods[fits_row].label;
  Progress progress(experiment.name, TotalWork(experiment, datasets, methods, inputs.shard));
  for (std::size_t c = 0; c < datasets.size() && !Stopped(inputs); ++c)
    RunCondition(experiment, inputs, c, *datasets[c], methods, progress, &results);
  progress.Finish();
  results.partial = Stopped(inputs);
  return results;
}

}  // namespace diffsac
