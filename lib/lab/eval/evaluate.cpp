#include "lab/eval/evaluate.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <ostream>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/diffsac_model.h"
#include "lab/config/make_estimator.h"
#include "lab/config/meant_paths.h"
#include "lab/config/run_directory.h"
#include "lab/config/run_lock.h"
#include "lab/config/yaml.h"
#include "lab/eval/example_files.h"
#include "lab/eval/merge.h"
#include "lab/eval/report_script.h"
#include "lab/eval/run_files.h"
#include "lab/eval/selection.h"
#include "lab/files/files.h"

namespace diffsac {

namespace {

// As YAML reads any text.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

/// The rows of a configuration, with all their keys.
std::vector<PlacedConfig> RowsOf(const EvalRequest& request) {
  const ExperimentOptions experiment = ReadExperiment(ConfigFromFile(request.config_path));
  std::vector<PlacedConfig> rows;
  for (const EstimatorRow& row : experiment.methods) try {
      rows.emplace_back("methods." + row.name, ResolvedRow(row.config, experiment.task, request.context));
    } catch (const Error&) {
      continue;  // Its network is not there, say.
    }
  return rows;
}

ExperimentOptions Read(const Config& config, const EvalRequest& request) {
  try {
    return ReadExperiment(config);
  } catch (const Error& error) {
    throw Error(WithMeantPaths(error, request.assignments, [&] { return RowsOf(request); }));
  }
}

}  // namespace

ExperimentOptions ReadRequest(const EvalRequest& request) {
  Config config = ConfigFromFile(request.config_path);
  for (const std::string& assignment : request.assignments) SetYaml(&config, assignment);
  if (request.seed >= 0) SetYaml(&config, "seed=" + std::to_string(request.seed));
  if (request.seed >= 0) SetYaml(&config, "seeds=~");
  if (request.context.threads > 0) SetYaml(&config, "threads=" + std::to_string(request.context.threads));
  if (!request.data_root.empty()) SetYaml(&config, "data_root=" + Quoted(request.data_root));
  ExperimentOptions experiment = Read(config, request);
  SelectEstimators(request.methods, &experiment);
  if (request.limit > 0) experiment.problems = std::min(experiment.problems, request.limit);
  return experiment;
}

namespace {

// What shards must have in common beside the experiment.
std::string Setup(const EvalRequest& request) {
  return "checkpoint: " + request.context.checkpoint_override + "\ndevice: " + request.context.device + "\n";
}

std::string Folder(const EvalRequest& request, const ExperimentOptions& experiment, const Shard& shard) {
  if (!request.output.empty()) return request.output;
  const std::string part = "-shard-" + std::to_string(shard.index) + "-of-" + std::to_string(shard.count);
  return "runs/" + experiment.name + (shard.whole() ? "" : part);
}

void WriteShard(const ExperimentResults& results, const std::string& setup, const std::string& folder,
                std::ostream& out) {
  WriteFileAtomically(folder + "/problems.csv", ProblemsCsv(results));
  WriteFits(results, folder);
  KeepEstimates(results, folder);
  WriteFileAtomically(folder + "/" + kShardRecords, ShardRecords(results, setup));
  out << results.experiment.name << ": shard " << ToString(results.shard) << " is in " << folder
      << (results.partial ? ", incomplete" : "; join all of them with diffsac_eval --merge") << std::endl;
}

Shard ShardOf(const EvalRequest& request) {
  if (request.group) return {request.group->rank + 1, request.group->size};
  return request.shard.empty() ? Shard() : ShardFromText(request.shard);
}

ExperimentResults Run(const EvalRequest& request, ExperimentOptions experiment, const Shard& shard,
                      const TraceConfidence& trace, const std::atomic<bool>& stop) {
  EstimatorContext context = request.context;
  if (request.group && experiment.threads == 0) experiment.threads = request.group->threads;
  context.threads = experiment.threads;
  return RunExperiment(
      experiment, {[&](const Config& row, Task task) { return MakeRow(row, task, context); }, trace, &stop, shard});
}

// At rank 0 the results become those of all processes; false elsewhere, where there is nothing left to do.
bool JoinShards(const WorkGroup& group, const std::string& setup, ExperimentResults* results) {
  const std::vector<std::string> texts = group.gather(ShardRecords(*results, setup));
  const bool estimates = results->experiment.estimates;
  const std::vector<std::string> files =
      estimates ? group.gather(EstimatesToBytes(EstimatesOf(*results))) : std::vector<std::string>();
  if (group.rank != 0) return false;
  std::vector<ShardContent> shards;
  for (std::size_t r = 0; r < texts.size(); ++r) {
    const std::string process = "process " + std::to_string(r);
    shards.push_back(ReadShardRecords(texts[r], process));
    if (estimates) AddEstimates(EstimatesFromBytes(files[r], process), process, &shards.back().results);
  }
  ExperimentResults joined = MergeShards(std::move(shards), true);
  joined.fits = std::move(results->fits);
  joined.traces = std::move(results->traces);
  *results = std::move(joined);
  return true;
}

void CheckRequest(const EvalRequest& request) {
  if (request.group.has_value() && (!request.merge.empty() || !request.shard.empty()))
    throw Error("--shard and --merge are for processes alone; processes of a launcher share the work by themselves");
  const bool shared = request.group.has_value() || !request.shard.empty();
  if (shared && (request.train_missing || request.update))
    throw Error("--train-missing and --update are for one process that does all of the work");
  RefuseInputsAsOutputs({request.colmap.database}, {request.config_path, request.context.checkpoint_override});
}

/// The plain values of a configuration, and so the files that it names.
void AddValuesOf(const Config& config, std::vector<std::string>* values) {
  const std::vector<std::string> keys = config.Keys();
  for (const std::string& key : keys) AddValuesOf(config.Sub(key), values);
  if (!keys.empty()) return;
  try {
    for (const Config& item : config.Sequence("")) AddValuesOf(item, values);
  } catch (const Error&) {
    values->push_back(config.Text());  // No list.
  }
}

/// A value's file, or the data files of its folder; values that name neither add nothing.
void AddFilesOf(const std::string& value, std::vector<std::string>* files) {
  namespace fs = std::filesystem;
  std::error_code code;
  if (fs::is_regular_file(value, code)) files->push_back(value);
  if (!fs::is_directory(value, code)) return;
  for (fs::directory_iterator at(value, code), end; !code && at != end; at.increment(code))
    if (at->is_regular_file(code) && at->path().extension() != ".md") files->push_back(at->path().string());
}

/// Of what the run writes nothing may be what it reads; what an earlier run left in its folder is replaced.
void RefuseInputs(const EvalRequest& request, const ExperimentOptions& experiment, const std::string& folder) {
  std::vector<std::string> values = {request.context.checkpoint_override}, outputs, files;
  for (const Condition& condition : experiment.conditions) AddValuesOf(condition.data, &values);
  for (const EstimatorRow& row : experiment.methods) AddValuesOf(row.config, &values);
  for (const std::string& value : values) AddFilesOf(value, &files);
  files.push_back(request.config_path);
  if (ProgramOfRun(folder).empty())
    for (const char* name :
         {"config.yaml", "report.html", "table.md", "table.csv", "table.tex", "problems.csv", "results.csv",
          "results.json", "reliability.csv", kEstimatesFile, kFitsFile, kPairsFile, kShardRecords})
      outputs.push_back(folder + "/" + name);
  RefuseInputsAsOutputs(outputs, files);
}

// Trains what is asked for and leaves out what is missing. False: `*code` is how the program ends.
bool MakeReady(const EvalRequest& request, const std::atomic<bool>& stop, ExperimentOptions* experiment,
               std::ostream& out, int* code) {
  const bool main = !request.group || request.group->rank == 0;
  *code = kExitOk;
  if (request.needs) {
    for (const std::string& folder : NeededFolders(*experiment)) out << folder << "\n";
    return false;
  }
  if (request.train_missing && !TrainNetworks(MissingNetworks(*experiment), request.training_device, stop)) {
    *code = kExitInterrupted;
    return false;
  }
  const bool something = LeaveOutMissing(!request.context.checkpoint_override.empty(), experiment);
  if (something) {
    for (const std::string& what : experiment->left_out) LogWarning("left out: " + what);
  } else if (main) {
    out << NothingIsHere(*experiment) << std::endl;
  }
  return something;
}

}  // namespace

int Evaluate(const EvalRequest& request, const TraceConfidence& trace, const std::atomic<bool>& stop,
             std::ostream& out) {
  CheckRequest(request);
  CheckDevice(request.context.device);  // before an earlier run's results are touched
  if (!request.merge.empty()) {
    MergeFolders(request.merge, request.output, out);
    return kExitOk;
  }
  ExperimentOptions experiment = ReadRequest(request);
  if (request.rows) {
    for (const EstimatorRow& row : experiment.methods) out << row.label << "\n";
    for (const auto& [label, values] : experiment.paper) out << label << "\n";
    return kExitOk;
  }
  if (experiment.seeds && !request.colmap.database.empty())
    throw Error("--export-colmap is for one run; of several seeds choose one with --seed");
  if (experiment.seeds) return EvaluateSeeds(request, experiment, trace, stop, out);
  int code = kExitOk;
  if (!MakeReady(request, stop, &experiment, out, &code)) return code;
  CheckColmapExport(experiment, request.colmap);
  const Shard shard = ShardOf(request);
  const std::string folder = Folder(request, experiment, request.group ? Shard() : shard);
  RefuseInputs(request, experiment, folder);
  if (request.update && IsMade(WithResolvedRows(experiment, request.context), folder)) {
    out << experiment.name << ": made already, in " << folder << std::endl;
    // It was not where a disk was full or the process was killed.
    if (experiment.report && !std::filesystem::exists(folder + "/" + kReportFile)) WriteReport(folder);
    return kExitOk;
  }
  std::optional<RunLock> lock;
  std::optional<RunDirectory> run;
  if (!request.group || request.group->rank == 0) {
    lock.emplace(folder);
    // Before the work, so that a read-only folder is not found out afterwards.
    BeginResults(folder);
    run.emplace(folder, "diffsac_eval", WriteExperiment(WithResolvedRows(experiment, request.context)),
                experiment.seed);
    RemoveFile(run->File(kShardRecords));  // An earlier run's: it would pass for this one's until the end.
  }
  ExperimentResults results = Run(request, experiment, shard, trace, stop);
  if (request.group.has_value() && !JoinShards(*request.group, Setup(request), &results))
    return results.partial ? kExitInterrupted : kExitOk;
  if (request.shard.empty())
    WriteWholeRun(results, "", folder, out);
  else
    WriteShard(results, Setup(request), folder, out);
  if (!results.partial) ExportColmap(results, request.colmap, out);
  if (request.shard.empty()) out << ResultsText(folder) << std::endl;
  if (results.partial) LogWarning("interrupted: partial results are in " + folder);
  return results.partial || stop ? kExitInterrupted : kExitOk;
}

}  // namespace diffsac
