#include "diffsac/eval/command_line.h"

#include <algorithm>
#include <ostream>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/run_directory.h"
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
  if (request.context.checkpoint_override.empty()) LeaveOutUnavailable(&experiment);
  if (request.limit > 0) experiment.problems = std::min(experiment.problems, request.limit);
  return experiment;
}

int Evaluate(const EvalRequest& request, const TraceConfidence& trace, const std::atomic<bool>& stop,
             std::ostream& out) {
  const ExperimentOptions experiment = ReadRequest(request);
  const std::vector<std::string> missing = MissingData(experiment);
  if (experiment.optional_data && !missing.empty()) {
    out << experiment.name << ": skipped, its data is not here: " << missing.front() << std::endl;
    return kExitOk;
  }
  MethodContext context = request.context;
  context.threads = experiment.threads;
  const std::string folder = request.output.empty() ? "runs/" + experiment.name : request.output;
  // Before the work, so that a read-only folder is not found out afterwards.
  const RunDirectory run(folder, "diffsac_eval", WriteExperiment(experiment), experiment.seed);
  const RunInputs inputs{[&](const Config& row, Task task) { return MakeMethod(row, task, context); }, trace, &stop};
  const ExperimentResults results = RunExperiment(experiment, inputs);
  WriteResults(results, folder);
  if (!results.partial) DrawFigures(results, folder);
  out << MarkdownReport(results) << std::endl;
  if (results.partial) LogWarning("interrupted: partial results are in " + folder);
  return results.partial ? kExitInterrupted : kExitOk;
}

}  // namespace diffsac
