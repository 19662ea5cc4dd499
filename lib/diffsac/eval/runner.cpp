#include "diffsac/eval/runner.h"

#include <algorithm>
#include <filesystem>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/progress.h"
#include "diffsac/core/random.h"
#include "diffsac/data/dataset_factory.h"
#include "diffsac/methods/oracle.h"

namespace diffsac {
namespace {

bool Stopped(const RunInputs& inputs) { return inputs.stop != nullptr && inputs.stop->load(); }

struct DataType {
  std::string type;
  std::vector<std::string> paths;
};

DataType PeekData(const Config& data) {
  DataType peek;
  if (data.Has("type")) peek.type = data.Text("type");
  for (const Config& item : data.Sequence("paths")) peek.paths.push_back(item.Text());
  return peek;
}

std::vector<std::unique_ptr<Dataset>> MakeDatasets(const ExperimentOptions& experiment) {
  std::vector<std::unique_ptr<Dataset>> datasets;
  for (const Condition& condition : experiment.conditions) {
    datasets.push_back(MakeDataset(condition.data, experiment.seed));
    if (ToString(datasets.back()->task()) != experiment.task)
      throw Error("condition '" + condition.name + "': its data is for task '" + ToString(datasets.back()->task()) +
                  "', the experiment for '" + experiment.task + "'");
  }
  return datasets;
}

// Null for the oracle, which is no Method.
std::vector<std::unique_ptr<Method>> MakeMethods(const ExperimentOptions& experiment, const MethodFactory& make) {
  std::vector<std::unique_ptr<Method>> methods;
  const Task task = TaskFromString(experiment.task);
  for (const MethodRow& row : experiment.methods)
    methods.push_back(row.type == "oracle" ? nullptr : make(row.config, task));
  return methods;
}

std::vector<Example> LoadExamples(const Dataset& dataset, const ExperimentOptions& experiment) {
  std::int64_t count = experiment.problems;
  if (dataset.size() >= 0) count = std::min(count, dataset.size());
  std::vector<Example> examples(static_cast<std::size_t>(count));
  ParallelFor(count, experiment.threads, [&](std::int64_t i) { examples[i] = dataset.Get(i); });
  return examples;
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
  record.report = estimate.report;
  record.done = true;
  return record;
}

/// Everything that one cell's loop needs.
struct CellRun {
  const ExperimentOptions& experiment;
  const RunInputs& inputs;
  const std::vector<Example>& examples;
  const Method* method;  // null: the oracle
  Progress& progress;

  Estimate EstimateOne(const Example& example) const {
    if (method == nullptr) return OracleEstimate(example.problem, example.truth);
    return method->Estimate(example.problem, ProblemSeed(experiment.seed, example.index));
  }
};

void RunOneByOne(const CellRun& run, std::vector<ProblemRecord>* records) {
  ParallelFor(static_cast<std::int64_t>(records->size()), run.experiment.threads, [&](std::int64_t i) {
    if (Stopped(run.inputs)) return;
    (*records)[i] = MakeRecord(run.experiment, run.examples[i], run.EstimateOne(run.examples[i]));
    run.progress.Advance();
  });
}

void RunInBatches(const CellRun& run, std::vector<ProblemRecord>* records) {
  const auto batch = static_cast<std::size_t>(run.method->PreferredBatch());
  for (std::size_t first = 0; first < records->size() && !Stopped(run.inputs); first += batch) {
    const std::size_t last = std::min(first + batch, records->size());
    std::vector<Problem> problems;
    std::vector<std::uint64_t> seeds;
    for (std::size_t i = first; i < last; ++i) {
      problems.push_back(run.examples[i].problem);
      seeds.push_back(ProblemSeed(run.experiment.seed, run.examples[i].index));
    }
    const std::vector<Estimate> estimates = run.method->EstimateBatch(problems, seeds);
    for (std::size_t i = first; i < last; ++i)
      (*records)[i] = MakeRecord(run.experiment, run.examples[i], estimates[i - first]);
    run.progress.Advance(static_cast<std::int64_t>(last - first));
  }
}

std::vector<ProblemRecord> RunCell(const CellRun& run, int max_problems) {
  std::size_t count = run.examples.size();
  if (max_problems > 0) count = std::min(count, static_cast<std::size_t>(max_problems));
  std::vector<ProblemRecord> records(count);
  // Caches, allocators and networks are slow the first time: that is not part of a method's milliseconds.
  if (count > 0 && !Stopped(run.inputs)) run.EstimateOne(run.examples.front());
  if (run.method != nullptr && run.method->PreferredBatch() > 1) {
    RunInBatches(run, &records);
  } else {
    RunOneByOne(run, &records);
  }
  std::erase_if(records, [](const ProblemRecord& record) { return !record.done; });
  return records;
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
  const bool one = !IsTwoView(TaskFromString(experiment.task)) || !figures.qualitative_method.empty();
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
void KeepFits(const CellRun& run, std::size_t condition, std::size_t method, ExperimentResults* results) {
  const std::size_t count = std::min<std::size_t>(run.experiment.figures.qualitative, run.examples.size());
  const bool spread = IsTwoView(TaskFromString(run.experiment.task));
  for (std::size_t i = 0; i < count && !Stopped(run.inputs); ++i) {
    const Example& example = run.examples[spread ? i * run.examples.size() / count : i];
    results->fits.push_back({condition, example, run.EstimateOne(example), method});
  }
}

void KeepTrace(const CellRun& run, const std::string& label, ExperimentResults* results) {
  if (!run.inputs.trace || !results->traces.empty() || run.examples.empty() || Stopped(run.inputs)) return;
  const Example& example = run.examples.front();
  auto trace = run.inputs.trace(*run.method, example.problem, ProblemSeed(run.experiment.seed, example.index));
  if (trace.has_value()) results->traces.push_back({example, std::move(*trace), label});
}

std::int64_t TotalWork(const ExperimentOptions& experiment, const std::vector<std::unique_ptr<Dataset>>& datasets) {
  std::int64_t total = 0;
  for (std::size_t c = 0; c < datasets.size(); ++c) {
    for (const MethodRow& row : experiment.methods) {
      std::int64_t count = experiment.problems;
      if (datasets[c]->size() >= 0) count = std::min(count, datasets[c]->size());
      if (row.max_problems > 0) count = std::min<std::int64_t>(count, row.max_problems);
      if (row.RunsOn(experiment.conditions[c].name)) total += count;
    }
  }
  return total;
}

// A group without a scene is most likely a misspelt name, but data that is not here may have it.
void WarnOfEmptyGroups(const ExperimentOptions& experiment, const std::vector<Example>& examples) {
  for (const SceneGroup& group : experiment.scene_groups) {
    const bool used = std::any_of(examples.begin(), examples.end(), [&](const Example& example) {
      return experiment.GroupOf(example.scene) == group.name;
    });
    if (!used && !examples.empty()) LogWarning("scene_groups: no scene of the data is in '" + group.name + "'");
  }
}

void RunCondition(const ExperimentOptions& experiment, const RunInputs& inputs, std::size_t condition,
                  const Dataset& dataset, const std::vector<std::unique_ptr<Method>>& methods, Progress& progress,
                  ExperimentResults* results) {
  const std::vector<Example> examples = LoadExamples(dataset, experiment);
  if (condition == 0) WarnOfEmptyGroups(experiment, examples);
  const std::vector<std::size_t> fits_rows = FitsRows(experiment);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const MethodRow& row = experiment.methods[m];
    if (!row.RunsOn(experiment.conditions[condition].name) || Stopped(inputs)) continue;
    const CellRun run{experiment, inputs, examples, methods[m].get(), progress};
    Cell cell{condition, m, RunCell(run, row.max_problems)};
    if (!cell.records.empty()) results->cells.push_back(std::move(cell));
    if (std::find(fits_rows.begin(), fits_rows.end(), m) != fits_rows.end() && ShowsFits(experiment, condition))
      KeepFits(run, condition, m, results);
    if (run.method != nullptr && ShowsTrace(experiment, condition)) KeepTrace(run, row.label, results);
  }
}

}  // namespace

std::uint64_t ProblemSeed(std::uint64_t experiment_seed, std::uint64_t problem_index) {
  return Rng(experiment_seed).Fork("estimate", problem_index).Seed();
}

std::vector<std::string> MissingData(const ExperimentOptions& experiment) {
  std::vector<std::string> missing;
  for (const Condition& condition : experiment.conditions)
    for (const std::string& path : PeekData(condition.data).paths)
      if (!std::filesystem::exists(path) && std::find(missing.begin(), missing.end(), path) == missing.end())
        missing.push_back(path);
  return missing;
}

ExperimentResults RunExperiment(const ExperimentOptions& experiment, const RunInputs& inputs) {
  ExperimentResults results;
  results.experiment = experiment;
  const auto datasets = MakeDatasets(experiment);
  const auto methods = MakeMethods(experiment, inputs.make_method);
  results.dataset = PeekData(experiment.conditions.front().data).type;
  const int fits_row = FitsRow(experiment);
  if (fits_row >= 0) results.fits_label = experiment.methods[fits_row].label;
  Progress progress(experiment.name, TotalWork(experiment, datasets));
  for (std::size_t c = 0; c < datasets.size() && !Stopped(inputs); ++c)
    RunCondition(experiment, inputs, c, *datasets[c], methods, progress, &results);
  progress.Finish();
  results.partial = Stopped(inputs);
  return results;
}

}  // namespace diffsac
