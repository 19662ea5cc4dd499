#include "lab/report/run_sweep.h"

#include <cctype>
#include <filesystem>
#include <optional>
#include <ostream>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/run_directory.h"
#include "lab/config/run_lock.h"
#include "lab/config/yaml.h"
#include "lab/eval/report_script.h"
#include "lab/eval/selection.h"
#include "lab/eval/sweep.h"
#include "lab/report/markdown_report.h"
#include "lab/report/merge.h"
#include "lab/report/result_files.h"
#include "lab/report/results_page.h"
#include "lab/report/run_files.h"
#include "lab/report/run_reader.h"

namespace diffsac {
namespace {

/// What was asked for: config.yaml is, in the end, that of the one table which it came to.
constexpr const char* kSweepFile = "sweep.yaml";

/// The configuration with the command line's assignments, axes included.
Config GivenConfig(const EvalRequest& request) {
  Config config = ConfigFromFile(request.config_path);
  for (const std::string& assignment : request.assignments) SetYaml(&config, assignment);
  return config;
}

std::string FolderName(const std::string& point) {
  std::string name = point;
  for (char& c : name)
    if (c == ' ')
      c = ',';
    else if (!std::isalnum(static_cast<unsigned char>(c)) && std::string("=.-+,").find(c) == std::string::npos)
      c = '_';
  return name;
}

EvalRequest RequestOf(const SweepPoint& point, const EvalRequest& request, const std::string& folder) {
  EvalRequest one = request;
  one.assignments.insert(one.assignments.end(), point.assignments.begin(), point.assignments.end());
  one.output = (std::filesystem::path(folder) / "points" / FolderName(point.name)).string();
  one.update = one.one_point = true;
  one.page.clear();
  return one;
}

/// Reads every point before anything runs, so that a wrong value is found now, and takes away those of which nothing is
/// here, which `out` is told once for all that lack the same. Returns the first, as it is read.
ExperimentOptions CheckPoints(const EvalRequest& request, std::vector<SweepPoint>* points, std::ostream& out) {
  std::optional<ExperimentOptions> first;
  std::string told;
  // Networks that are trained first may not be there yet.
  const bool any_checkpoint = request.train_missing || !request.context.checkpoint_override.empty();
  std::erase_if(*points, [&](const SweepPoint& point) {
    ExperimentOptions experiment = ReadRequest(RequestOf(point, request, ""));
    if (!first) first = experiment;
    if (request.needs) return false;
    if (LeaveOutMissing(any_checkpoint, &experiment)) {
      if (!request.train_missing) WithResolvedRows(experiment, request.context);
      return false;
    }
    const std::string text = NothingIsHere(experiment);
    if (text != told) out << text << std::endl;
    told = text;
    return true;
  });
  return *first;
}

/// Fits of single problems are the first seed's.
void WriteJoined(ExperimentResults results, const std::string& first_point, const EvalRequest& request,
                 const std::string& folder, std::ostream& out) {
  // The points may have other data: pictures of pairs are in their own reports.
  for (Cell& cell : results.cells) cell.estimates.clear();
  const Report report = MakeReport(results);
  RunDirectory(folder, "diffsac_eval", WriteExperiment(results.experiment), results.experiment.seed);
  WriteResults(report, folder);
  if (!results.seeds.empty()) CopyFits(first_point, folder);
  EndResults(report, folder);
  TellRun(folder);
  if (!request.page.empty()) WritePage(folder, request.page, request.page_command);
  out << MarkdownReport(report) << "\n" << ResultsText(folder) << std::endl;
}

}  // namespace

bool IsSweep(const EvalRequest& request) {
  return !request.one_point && !request.config_path.empty() && !SweepAxes(GivenConfig(request)).empty();
}

int EvaluateSweep(const EvalRequest& request, const TraceConfidence& trace, const std::atomic<bool>& stop,
                  std::ostream& out) {
  if (request.group || !request.shard.empty())
    throw Error("a sweep of whole runs is for one process: start its points one by one with --set, or without --shard");
  const Config config = GivenConfig(request);
  std::vector<SweepPoint> points = SweepPoints(SweepAxes(config));
  const ExperimentOptions first = CheckPoints(request, &points, out);
  if (points.empty()) return kExitOk;
  const std::string folder = request.output.empty() ? "runs/" + first.name : request.output;
  std::optional<RunLock> lock;
  if (!request.needs) {
    lock.emplace(folder);
    BeginResults(folder);
    const RunDirectory run(folder, "diffsac_eval", ToYaml(config) + "\n", first.seed);
    WriteFileAtomically(run.File(kSweepFile), ToYaml(config) + "\n");
  }
  std::vector<ExperimentResults> results;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const EvalRequest one = RequestOf(points[p], request, folder);
    std::ostringstream table;
    const int code = Evaluate(one, trace, stop, request.needs ? out : table);
    if (request.needs) continue;
    if (code != kExitOk) {
      LogWarning("interrupted at " + points[p].name + ": the same call goes on from there");
      return code;
    }
    out << "[" << p + 1 << "/" << points.size() << "] " << points[p].name << ": in " << one.output << std::endl;
    results.push_back(ReadRun(one.output));
  }
  if (!request.needs)
    WriteJoined(JoinSweep(points, results), RequestOf(points.front(), request, folder).output, request, folder, out);
  return kExitOk;
}

}  // namespace diffsac
