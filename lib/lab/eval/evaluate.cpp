#include "lab/eval/evaluate.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <ostream>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/diffsac_model.h"
#include "lab/config/make_estimator.h"
#include "lab/config/paths.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "lab/eval/run_files.h"
#include "lab/eval/selection.h"
#include "lab/eval/terminal_table.h"
#include "lab/files/files.h"

namespace diffsac {

namespace {

// As YAML reads any text.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace

ExperimentOptions ReadRequest(const EvalRequest& request) {
  Config config = ConfigFromFile(request.config_path);
  for (const std::string& assignment : request.assignments) SetYaml(&config, assignment);
  if (request.seed >= 0) SetYaml(&config, "seed=" + std::to_string(request.seed));
  if (request.seed >= 0) SetYaml(&config, "seeds=~");
  if (request.context.threads > 0) SetYaml(&config, "threads=" + std::to_string(request.context.threads));
  if (!request.data_root.empty()) SetYaml(&config, "data_root=" + Quoted(request.data_root));
  ExperimentOptions experiment = ReadExperiment(config);
  SelectEstimators(request.methods, &experiment);
  if (request.limit > 0) experiment.problems = std::min(experiment.problems, request.limit);
  return experiment;
}

namespace {

std::string Folder(const EvalRequest& request, const ExperimentOptions& experiment, const Shard& shard) {
  if (!request.output.empty()) return request.output;
  const std::string part = "-shard-" + std::to_string(shard.index) + "-of-" + std::to_string(shard.count);
  return "runs/" + experiment.name + (shard.whole() ? "" : part);
}

ExperimentResults Run(const EvalRequest& request, ExperimentOptions experiment, const Shard& shard,
                      const TraceConfidence& trace, const std::atomic<bool>& stop) {
  EstimatorContext context = request.context;
  context.threads = experiment.threads;
  return RunExperiment(
      experiment, {[&](const Config& row, Task task) { return MakeRow(row, task, context); }, trace, &stop, shard});
}

RunSetup SetupOf(const EvalRequest& request) { return {request.context.checkpoint_override, request.context.device}; }

Shard ShardOf(const EvalRequest& request) { return request.shard.empty() ? Shard() : ShardFromText(request.shard); }

/// Of what the run writes nothing may be what it reads; what an earlier run left in its folder is replaced.
void RefuseInputs(const EvalRequest& request, const ExperimentOptions& experiment, const std::string& folder) {
  std::vector<std::string> inputs = DataPaths(experiment), outputs;
  for (const std::string& file : RowFiles(experiment)) inputs.push_back(file);
  inputs.insert(inputs.end(), {request.config_path, request.context.checkpoint_override});
  if (ProgramOfRun(folder).empty())
    for (const char* name : {"config.yaml", "problems.csv", kEstimatesFile, kRunFile})
      outputs.push_back(folder + "/" + name);
  RefuseInputsAsOutputs(outputs, inputs);
}

// Trains what is asked for and leaves out what is missing. False: `*code` is how the program ends.
bool MakeReady(const EvalRequest& request, const std::atomic<bool>& stop, ExperimentOptions* experiment,
               std::ostream& out, int* code) {
  *code = kExitOk;
  if (request.needs) {
    for (const std::string& folder : NeededFolders(*experiment, request.train_missing)) out << folder << "\n";
    return false;
  }
  if (request.train_missing && !TrainNetworks(MissingNetworks(*experiment), request.training_device, stop)) {
    *code = kExitInterrupted;
    return false;
  }
  const bool something = LeaveOutMissing(!request.context.checkpoint_override.empty(), experiment);
  if (!something) out << NothingIsHere(*experiment) << std::endl;
  for (const std::string& what : experiment->left_out)
    if (something) LogWarning("left out: " + what);
  return something;
}

/// Where scripts/report is.
std::string ReportScripts() {
  try {
    return std::filesystem::exists("scripts/report") ? "scripts/report" : SharedFile("report");
  } catch (const Error&) {
    return "scripts/report";
  }
}

void SayWhere(const std::string& folder, std::ostream& out) {
  out << "results are in " << folder << "; for a report: python3 " << ReportScripts() << " " << folder << std::endl;
}

/// One seed. The folder is locked by the caller where it is one of several.
int EvaluateOne(const EvalRequest& request, ExperimentOptions experiment, const TraceConfidence& trace,
                const std::atomic<bool>& stop, std::ostream& out) {
  int code = kExitOk;
  if (!MakeReady(request, stop, &experiment, out, &code)) return code;
  CheckColmapExport(experiment, request.colmap);
  const Shard shard = ShardOf(request);
  const std::string folder = Folder(request, experiment, shard);
  RefuseInputs(request, experiment, folder);
  const ExperimentOptions resolved = WithResolvedRows(experiment, request.context);
  if (request.update && IsMade(resolved, SetupOf(request), shard, folder)) {
    UpdateCaptions(resolved, folder);
    out << experiment.name << ": made already, in " << folder << std::endl;
    return kExitOk;
  }
  const RunLock lock(folder);
  // Before the work, so that a read-only folder is not found out afterwards.
  RemoveFile(folder + "/" + kRunFile);
  const RunDirectory run(folder, "diffsac_eval", WriteExperiment(resolved), experiment.seed);
  const ExperimentResults results = Run(request, std::move(experiment), shard, trace, stop);
  WriteRun(results, SetupOf(request), folder);
  PrintTable(results, out);
  if (!results.partial) ExportColmap(results, request.colmap, out);
  SayWhere(folder, out);
  if (results.partial) LogWarning("interrupted: partial results are in " + folder);
  return results.partial || stop ? kExitInterrupted : kExitOk;
}

EvalRequest RequestOf(int seed, const EvalRequest& request, const std::string& folder) {
  EvalRequest one = request;
  one.seed = seed;
  one.output = (std::filesystem::path(folder) / SeedFolder(seed)).string();
  one.update = true;
  return one;
}

/// The seeds with which something can run, each read before anything runs, so that a wrong value is found now. `out` is
/// told once what all lack.
std::vector<int> CheckedSeeds(const EvalRequest& request, const std::vector<int>& seeds, std::ostream& out) {
  std::string told;
  // Networks that are trained first may not be there yet.
  const bool any_checkpoint = request.train_missing || !request.context.checkpoint_override.empty();
  std::vector<int> checked;
  for (const int seed : seeds) {
    ExperimentOptions experiment = ReadRequest(RequestOf(seed, request, ""));
    if (request.needs || LeaveOutMissing(any_checkpoint, &experiment)) {
      if (!request.needs && !request.train_missing) WithResolvedRows(experiment, request.context);
      checked.push_back(seed);
      continue;
    }
    const std::string text = NothingIsHere(experiment);
    if (text != told) out << text << std::endl;
    told = text;
  }
  return checked;
}

int EvaluateSeeds(const EvalRequest& request, const ExperimentOptions& experiment, const TraceConfidence& trace,
                  const std::atomic<bool>& stop, std::ostream& out) {
  if (!request.shard.empty()) throw Error("--shard is for one seed: choose it with --seed");
  const std::vector<int> seeds = CheckedSeeds(request, *experiment.seeds, out);
  const std::string folder = Folder(request, experiment, {});
  std::optional<RunLock> lock;
  if (!request.needs && !seeds.empty()) {
    lock.emplace(folder);
    RemoveFile(folder + "/" + kRunFile);
    const RunDirectory run(folder, "diffsac_eval", WriteExperiment(experiment), experiment.seed);
  }
  for (const int seed : seeds) {
    const EvalRequest one = RequestOf(seed, request, folder);
    const int code = EvaluateOne(one, ReadRequest(one), trace, stop, out);
    if (code == kExitOk) continue;
    LogWarning("interrupted at seed " + std::to_string(seed) + ": the same call goes on from there");
    return code;
  }
  if (!lock) return kExitOk;
  WriteFileAtomically(folder + "/" + kRunFile, SeedsJson(experiment, seeds));
  SayWhere(folder, out);
  return kExitOk;
}

}  // namespace

int Evaluate(const EvalRequest& request, const TraceConfidence& trace, const std::atomic<bool>& stop,
             std::ostream& out) {
  if (!request.shard.empty() && (request.train_missing || request.update))
    throw Error("--train-missing and --update are for one process that does all of the work");
  RefuseInputsAsOutputs({request.colmap.database}, {request.config_path, request.context.checkpoint_override});
  CheckDevice(request.context.device);  // Before an earlier run's results are touched.
  const ExperimentOptions experiment = ReadRequest(request);
  if (request.rows) {
    for (const EstimatorRow& row : experiment.methods) out << row.label << "\n";
    return kExitOk;
  }
  if (experiment.seeds && !request.colmap.database.empty())
    throw Error("--export-colmap is for one run; of several seeds choose one with --seed");
  return experiment.seeds ? EvaluateSeeds(request, experiment, trace, stop, out)
                          : EvaluateOne(request, experiment, trace, stop, out);
}

}  // namespace diffsac
