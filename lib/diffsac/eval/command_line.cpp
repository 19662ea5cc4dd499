#include "diffsac/eval/command_line.h"

#include <algorithm>
#include <filesystem>
#include <ostream>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/run_directory.h"
#include "diffsac/eval/merge.h"
#include "diffsac/eval/outputs.h"
#include "diffsac/eval/plots.h"
#include "diffsac/eval/tables.h"

namespace diffsac {

ExperimentOptions ReadRequest(const EvalRequest& request) {
  Config config = Config::FromFile(request.config_path);
  for (const std::string& assignment : request.assignments) config.Set(assignment);
  if (request.seed >= 0) config.Set("seed=" + std::to_string(request.seed));
  if (request.context.threads > 0) config.Set("threads=" + std::to_string(request.context.threads));
  ExperimentOptions experiment = ReadExperiment(config);
  SelectMethods(request.methods, &experiment);
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
  if (!results.partial) DrawExamples(results, folder);
  WriteFileAtomically(folder + "/" + kShardRecords, ShardRecords(results, setup));
  out << results.experiment.name << ": shard " << ToString(results.shard) << " is in " << folder
      << (results.partial ? ", incomplete" : "; join all of them with diffsac_eval --merge") << std::endl;
}

void WriteWhole(const ExperimentResults& results, const std::string& folder, std::ostream& out) {
  WriteResults(results, folder);
  if (!results.partial) DrawFigures(results, folder);
  out << MarkdownReport(results) << std::endl;
}

}  // namespace

int Evaluate(const EvalRequest& request, const TraceConfidence& trace, const std::atomic<bool>& stop,
             std::ostream& out) {
  if (!request.merge.empty()) {
    MergeFolders(request.merge, request.output, out);
    return kExitOk;
  }
  const Shard shard = request.shard.empty() ? Shard() : ShardFromText(request.shard);
  const ExperimentOptions experiment = ReadRequest(request);
  const std::vector<std::string> missing = MissingData(experiment);
  if (experiment.optional_data && !missing.empty()) {
    out << experiment.name << ": skipped, its data is not here: " << missing.front() << std::endl;
    return kExitOk;
  }
  MethodContext context = request.context;
  context.threads = experiment.threads;
  const std::string folder = Folder(request, experiment, shard);
  // Before the work, so that a read-only folder is not found out afterwards.
  const RunDirectory run(folder, "diffsac_eval", WriteExperiment(experiment), experiment.seed);
  std::filesystem::remove(run.File(kShardRecords));  // An earlier run's: it would pass for this one's until the end.
  const RunInputs inputs{[&](const Config& row, Task task) { return MakeMethod(row, task, context); }, trace, &stop,
                         shard};
  const ExperimentResults results = RunExperiment(experiment, inputs);
  if (request.shard.empty())
    WriteWhole(results, folder, out);
  else
    WriteShard(results, Setup(request), folder, out);
  if (results.partial) LogWarning("interrupted: partial results are in " + folder);
  return results.partial ? kExitInterrupted : kExitOk;
}

}  // namespace diffsac
