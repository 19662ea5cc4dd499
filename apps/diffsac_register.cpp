// The rigid motion between two point clouds, or between every two scans of a folder: a text and the moved cloud, or a
// table and a pose graph. Of matches that somebody else made, also a similarity or several motions: this needs no
// Open3D.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/registration/matched_motion.h"
#ifdef DIFFSAC_HAS_CLOUDS
#include "lab/registration/registration_text.h"
#endif
#include "lab/config/number_checks.h"
#include "lab/config/process.h"
#include "lab/config/program.h"
#include "lab/config/run_directory.h"
#include "lab/config/terminal_log.h"
#include "lab/files/files.h"
#include "lab/images/given_matches.h"

namespace {

using namespace diffsac;
namespace fs = std::filesystem;

struct Request {
  std::vector<std::string> scans;
  std::string output, json, matches;
  Task task = Task::kRigid;
  double voxel = 0.0;
  bool overwrite = false, several = false;
  RegistrationOptions options;
};

void AddOptions(CLI::App* app, Request* request) {
  app->add_option("scans", request->scans, "Two clouds (PLY, PCD, XYZ, PTS), or a folder of them")->expected(1, 2);
  app->add_option("--from-matches", request->matches,
                  "Instead of clouds: matches of two, in a text file or CSV, a line each: x1 y1 z1 x2 y2 z2 and, if "
                  "known, ratio or score (with a header in any order); .npy, .npz and .h5 too");
  app->add_option_function<std::string>(
         "--task", [request](const std::string& name) { request->task = TaskFromString(name); },
         "Of --from-matches: rigid, or similarity, with a scale (default: rigid)")
      ->check(CLI::IsMember({"rigid", "similarity"}));
  app->add_flag("--several", request->several,
                "Of --from-matches: all rigid motions of things that move by themselves (default: no)");
  app->add_option("--voxel", request->voxel,
                  "Clouds are thinned out to one point in cubes of this side, in their unit (default: twice their "
                  "resolution, or as much as leaves 10 000 points)")
      ->check(NumberAbove(0));
  app->add_option("--max-distance", request->options.max_residual,
                  "The greatest distance of an inlier, in the second cloud's unit (default: twice the voxel; of "
                  "--from-matches twice the resolution of the second cloud's matched points)")
      ->check(NumberAbove(0));
  app->add_option("--output", request->output,
                  "Two clouds: where the first one goes, moved onto the second; empty: nowhere (default: aligned.ply). "
                  "A folder: the folder of registrations.csv and pose_graph.g2o (default: registered)");
  app->add_option("--json", request->json,
                  "Two clouds, or matches: also everything as JSON in this file (default: none)");
  app->add_flag("--overwrite", request->overwrite, "A folder: replaces results that are there (default: no)");
  app->add_option("--seed", request->options.seed, "Of the search; every pair has the same")
      ->check(NumberFrom(0))
      ->capture_default_str();
}

void WarnOf(const RigidMotionEstimate& estimate) {
  if (estimate.ambiguous_pose)
    LogWarning("another motion explains hardly fewer matches: the thing may be symmetric, or repeat itself");
  if (estimate.verdict == Verdict::kUnsupported)
    LogWarning("no more inliers than matches of unlike clouds would give: they may share nothing");
}

int RunMatches(const CLI::App& app, const Request& request) {
  for (const char* option : {"scans", "--voxel", "--output", "--overwrite"})
    if (app.count(option) > 0) throw Error(std::string(option) + " is for clouds, not for --from-matches");
  if (request.several && request.task != Task::kRigid) throw Error("--several is for --task rigid");
  RefuseInputsAsOutputs({request.json}, {request.matches});
  const Matches3D3D matches = ReadCloudMatches(request.matches);
  const auto write = [&](const std::string& json) {
    if (!request.json.empty()) WriteFileAtomically(request.json, json);
  };
  if (request.several) {
    const auto found = EstimateMultipleRigidMotions(matches, request.options);
    std::cout << MotionsText(found) << std::flush;
    write(MotionsJson(request.matches, found));
    return found.ok() ? kExitOk : kExitNoModel;
  }
  const MatchedMotion found = EstimateMatched(request.task, matches, request.options);
  std::cout << MotionText(found, found.estimate.pose.value_or(RigidMotion())) << std::flush;
  write(MatchedJson(request.matches, found));
  if (!found.estimate.ok()) return kExitNoModel;
  WarnOf(found.estimate);
  return kExitOk;
}

#ifdef DIFFSAC_HAS_CLOUDS

/// Also sets the greatest distance. Where all points are at one place anything does: nothing is found.
ScanPlan PlanOf(Request* request, const std::vector<std::string>& paths) {
  ScanPlan plan = PlanScans(paths);
  if (request->voxel > 0.0) plan.voxel = request->voxel;
  std::optional<double>& most = request->options.max_residual;
  if (!most) most = plan.voxel > 0.0 ? 2.0 * plan.voxel : 1.0;
  return plan;
}

int RunTwo(const CLI::App& app, Request request) {
  if (app.count("--overwrite") > 0) throw Error("--overwrite is for a folder of scans");
  if (app.count("--output") == 0) request.output = "aligned.ply";
  RefuseInputsAsOutputs({request.output, request.json}, request.scans);
  if (!request.output.empty()) CheckCloudName(request.output);
  const ScanPlan plan = PlanOf(&request, request.scans);
  const Scan first = ReadScan(request.scans[0], plan), second = ReadScan(request.scans[1], plan);
  const Registration found = RegisterScans(first, second, request.options);
  std::cout << "voxel: " << PlainNumber(plan.voxel) << "\n" << RegistrationText(first, second, found) << std::flush;
  if (!request.json.empty()) WriteFileAtomically(request.json, RegistrationJson(first, second, found));
  if (!found.estimate.ok()) return kExitNoModel;
  if (!request.output.empty()) {
    WriteMoved(first.path, found.motion, request.output);
    std::cout << "moved: " << request.output << std::endl;
  }
  if (found.slides())
    LogWarning(
        "the surfaces that overlap slide on each other, as planes, spheres and pipes do: they leave the motion open");
  WarnOf(found.estimate);
  return kExitOk;
}

void Say(const std::vector<Scan>& scans, const ScanPair& pair) {
  const RigidMotionEstimate& estimate = pair.registration.estimate;
  std::cout << scans[pair.first].name() << " - " << scans[pair.second].name() << ": ";
  if (!estimate.ok())
    std::cout << "no motion: " << ToString(estimate.status) << std::endl;
  else
    std::cout << estimate.num_inliers << " of " << pair.registration.matches << " matches, overlap "
              << std::lround(100.0 * pair.registration.overlap1) << " %"
              << (estimate.verdict == Verdict::kUnsupported ? ", may be chance" : "")
              << (estimate.ambiguous_pose ? ", ambiguous" : "") << (pair.registration.slides() ? ", slides" : "")
              << std::endl;
}

int RunFolder(const CLI::App& app, Request request) {
  if (app.count("--json") > 0) throw Error("--json is for two clouds");
  if (request.output.empty()) request.output = "registered";
  const std::string graph = (fs::path(request.output) / "pose_graph.g2o").string(),
                    table = (fs::path(request.output) / "registrations.csv").string();
  for (const std::string& file : {graph, table})
    if (!request.overwrite && fs::exists(file)) throw Error(file + ": is there already; --overwrite replaces it");
  const std::vector<std::string> paths = ScansOfFolder(request.scans[0]);
  if (paths.size() < 2) throw Error(request.scans[0] + ": expected a folder with two clouds or more");
  const ScanPlan plan = PlanOf(&request, paths);
  MakeWritableFolder(request.output);
  StopOnSignals();
  std::vector<Scan> scans;
  for (const std::string& path : paths) scans.push_back(ReadScan(path, plan));
  const int count = static_cast<int>(scans.size());
  std::vector<ScanPair> pairs;
  for (int i = 0; i < count && !stop_requested; ++i)
    for (int j = i + 1; j < count && !stop_requested; ++j) {
      pairs.push_back({i, j, RegisterScans(scans[i], scans[j], request.options)});
      Say(scans, pairs.back());
    }
  WriteFileAtomically(table, RegistrationsCsv(scans, pairs));
  WriteFileAtomically(graph, PoseGraphText(scans, pairs));
  const auto edges = std::count_if(pairs.begin(), pairs.end(), [](auto& pair) { return IsEdge(pair.registration); });
  std::cout << edges << " of " << pairs.size() << " pairs are edges of " << graph << std::endl;
  if (stop_requested) return kExitInterrupted;
  return edges > 0 ? kExitOk : kExitNoModel;
}

int RunClouds(const CLI::App& app, const Request& request) {
  if (request.scans.empty()) throw Error("expected two scans, a folder of them, or --from-matches");
  for (const char* option : {"--task", "--several"})
    if (app.count(option) > 0) throw Error(std::string(option) + " is for --from-matches");
  return request.scans.size() == 2 ? RunTwo(app, request) : RunFolder(app, request);
}

#else

int RunClouds(const CLI::App&, const Request&) {
  throw Error("it was built without Open3D and takes no clouds: --from-matches takes matches of two");
}

#endif

int Run(const CLI::App& app, const Request& request) {
  InitLogging("", false);
  return app.count("--from-matches") > 0 ? RunMatches(app, request) : RunClouds(app, request);
}

}  // namespace

int main(int argc, char** argv) {
  KeepFreedMemory();
  CLI::App app{"The rigid motion between two point clouds, by matches of them, or between every two scans of a folder"};
  Request request;
  app.set_version_flag("--version", VersionText("diffsac_register"));
  app.footer(
      "Examples:\n"
      "  diffsac_register a.ply b.ply                             R and t with y = R x + t; aligned.ply\n"
      "  diffsac_register a.ply b.ply --voxel 0.05 --json ab.json\n"
      "  diffsac_register scans --output graph                    all pairs of a folder: registrations.csv, "
      "pose_graph.g2o\n"
      "  diffsac_register --from-matches m.csv --task similarity  your own matches: x1 y1 z1 x2 y2 z2 [ratio]\n"
      "Exit status: 0 a motion (of a folder, one that may not be chance), 1 none, 2 bad input, 130 interrupted.\n"
      "More: docs/registration.md");
  AddOptions(&app, &request);
  return RunProgram("diffsac_register", &app, argc, argv, [&] { return Run(app, request); });
}
