#include "lab/eval/run_seeds.h"

#include <filesystem>
#include <optional>
#include <ostream>
#include <sstream>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/run_directory.h"
#include "lab/config/run_lock.h"
#include "lab/eval/join_seeds.h"
#include "lab/eval/markdown_report.h"
#include "lab/eval/merge.h"
#include "lab/eval/report_script.h"
#include "lab/eval/result_files.h"
#include "lab/eval/run_files.h"
#include "lab/eval/run_reader.h"
#include "lab/eval/selection.h"

namespace diffsac {
namespace {

EvalRequest RequestOf(int seed, const EvalRequest& request, const std::string& folder) {
  EvalRequest one = request;
  one.seed = seed;
  one.output = (std::filesystem::path(folder) / "points" / ("seed=" + std::to_string(seed))).string();
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

/// Fits of single problems are the first seed's.
void WriteJoined(ExperimentResults results, const std::string& first_run, const std::string& folder,
                 std::ostream& out) {
  // Pictures of pairs are in the runs' own reports.
  for (Cell& cell : results.cells) cell.estimates.clear();
  const Report report = MakeReport(results);
  ExperimentOptions whole = results.experiment;
  whole.seeds = std::vector<int>(results.seeds.begin(), results.seeds.end());
  RunDirectory(folder, "diffsac_eval", WriteExperiment(whole), whole.seed);
  WriteResults(report, folder);
  CopyFits(first_run, folder);
  EndResults(report, folder);
  TellRun(folder);
  out << MarkdownReport(report) << "\n" << ResultsText(folder) << std::endl;
}

}  // namespace

int EvaluateSeeds(const EvalRequest& request, const ExperimentOptions& experiment, const TraceConfidence& trace,
                  const std::atomic<bool>& stop, std::ostream& out) {
  if (request.group || !request.shard.empty())
    throw Error("several seeds are for one process: start them one by one with --seed, or without --shard");
  const std::vector<int> seeds = CheckedSeeds(request, *experiment.seeds, out);
  if (seeds.empty()) return kExitOk;
  const std::string folder = request.output.empty() ? "runs/" + experiment.name : request.output;
  std::optional<RunLock> lock;
  if (!request.needs) {
    lock.emplace(folder);
    BeginResults(folder);
    const RunDirectory run(folder, "diffsac_eval", WriteExperiment(experiment), experiment.seed);
  }
  std::vector<ExperimentResults> results;
  for (const int seed : seeds) {
    const EvalRequest one = RequestOf(seed, request, folder);
    std::ostringstream table;
    const int code = Evaluate(one, trace, stop, request.needs ? out : table);
    if (request.needs) continue;
    if (code != kExitOk) {
      LogWarning("interrupted at seed=" + std::to_string(seed) + ": the same call goes on from there");
      return code;
    }
    results.push_back(ReadRun(one.output));
    out << "[" << results.size() << "/" << seeds.size() << "] seed=" << seed << ": in " << one.output << std::endl;
  }
  if (!request.needs) WriteJoined(JoinSeeds(results), RequestOf(seeds.front(), request, folder).output, folder, out);
  return kExitOk;
}

}  // namespace diffsac
