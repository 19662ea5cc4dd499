// Estimates the model of two images: keypoints, matches, one row of an experiment, a text and a picture.
#include <CLI/CLI.hpp>

#include <cmath>
#include <iostream>

#include "data_tools/exif_focal.h"
#include "data_tools/match_picture.h"
#include "data_tools/match_two_images.h"
#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/memory.h"
#include "diffsac/core/resources.h"
#include "diffsac/core/status.h"
#include "diffsac/eval/selection.h"
#include "diffsac/lab/run_directory.h"
#include "diffsac/lab/terminal_log.h"
#include "diffsac/problem/pair_truth.h"
#include "diffsac/report/command_line.h"
#include "diffsac/report/pair_text.h"

namespace {

using namespace diffsac;

constexpr int kExitNoModel = 1;

struct Request {
  std::vector<std::string> images;
  std::string task, config_path, method, picture = "matches.png", json, matches;
  std::vector<std::string> assignments;
  GivenCalibration calibration;
  FeatureOptions features;
  double threshold_px = 0.0;  // 0: the task's
  EstimatorContext context;
  std::uint64_t seed = 0;
};

void AddOptions(CLI::App* app, Request* request) {
  app->add_option("images", request->images, "Two image files")->required()->expected(2);
  app->add_option(
         "--task", request->task,
         "essential (the default with a calibration), shared_focal (the default without: R, t and the focal length "
         "of both images, which EXIF data hint at), fundamental or homography")
      ->check(CLI::IsMember({"essential", "shared_focal", "fundamental", "homography"}));
  app->add_option("--calibration", request->calibration.file, "A file with the 3x3 matrix K of both images");
  app->add_option("--focal", request->calibration.focal, "Focal length of both images, in pixels");
  app->add_option("--center", request->calibration.center, "Principal point, as 320,240")->delimiter(',');
  app->add_option("--config", request->config_path,
                  "Estimators to choose from (default: configs/pair/TASK.yaml beside the program)");
  app->add_option("--method", request->method,
                  "The estimator: learned_prosac (the default; draws by a network, no reverse process runs), "
                  "prosac_marginalised (no network), ...");
  app->add_option("--set", request->assignments, "key.path=value, overrides the configuration")
      ->allow_extra_args(false);
  app->add_option("--checkpoint", request->context.checkpoint_override, "Replaces the estimator's network");
  app->add_option("--threshold-px", request->threshold_px,
                  "The most that an inlier's residual can be (1; homographies 3)")
      ->check(CLI::PositiveNumber);
  app->add_option_function<std::string>(
         "--features", [request](const std::string& name) { request->features.kind = FeatureKindFromString(name); },
         "sift, rootsift (the default) or orb")
      ->check(CLI::IsMember({"sift", "rootsift", "orb"}));
  app->add_option("--max-keypoints", request->features.max_keypoints, "The strongest of an image; 0: all");
  app->add_option("--max-image-size", request->features.max_image_size, "Reduce larger images to this side; 0: never");
  app->add_option("--picture", request->picture, "Where the picture goes; empty: none")->capture_default_str();
  app->add_option("--json", request->json, "Also everything as JSON in this file");
  app->add_option("--matches", request->matches,
                  "Also the matches in this file, a line each: x1 y1 x2 y2 ratio, and of "
                  "the keypoints log(size2 / size1) and angle2 - angle1 in radians");
  app->add_option("--device", request->context.device, "auto, cpu, cuda or cuda:INDEX");
  app->add_option("--threads", request->context.threads, "Threads (0: all cores)")->check(CLI::Range(0, 1024));
  app->add_option("--seed", request->seed, "Of the search");
}

std::string TaskOf(const Request& request) {
  const bool calibrated = !request.calibration.file.empty() || request.calibration.focal > 0.0;
  if (request.task == "essential" && !calibrated)
    throw Error("an essential matrix needs --calibration, or --focal and --center");
  if (request.task == "shared_focal" && calibrated)
    throw Error("shared_focal finds the focal length: it takes no --calibration and no --focal");
  if (!request.task.empty()) return request.task;
  return calibrated ? "essential" : "shared_focal";
}

/// Of one focal length for both images, where EXIF data say that there are two.
void WarnOfZoom(const Problem& problem) {
  const std::optional<FocalPrior>&first = problem.hint1.focal, &second = problem.hint2.focal;
  if (!first || !second || std::abs(std::log(first->focal / second->focal)) <= 2.0 * kExifLogSigma) return;
  LogWarning("EXIF data say that the focal lengths are " + std::to_string(std::lround(first->focal)) + " and " +
             std::to_string(std::lround(second->focal)) +
             " pixels, and shared_focal takes one for both images: --task fundamental takes none");
}

std::unique_ptr<RobustEstimator> EstimatorOf(const Request& request, const std::string& task) {
  EvalRequest rows;
  rows.config_path = request.config_path.empty() ? SharedFile("configs/pair/" + task + ".yaml") : request.config_path;
  rows.assignments = request.assignments;
  if (!request.method.empty()) rows.methods = {request.method};
  const ExperimentOptions experiment = ReadRequest(rows);
  if (experiment.methods.empty()) throw Error(rows.config_path + ": no methods");
  return MakeEstimator(experiment.methods.front().config, TaskFromString(task), request.context);
}

int Run(const Request& request) {
  const std::string task = TaskOf(request);
  const auto method = EstimatorOf(request, task);
  MatchedImages matched = MatchTwoImages(request.images[0], request.images[1], request.features, request.calibration);
  const double threshold = request.threshold_px > 0.0 ? request.threshold_px : task == "homography" ? 3.0 : 1.0;
  SetTask(TaskFromString(task), threshold, &matched.pair);
  if (task == "shared_focal") WarnOfZoom(matched.pair.problem);
  const Estimate estimate = method->Run(matched.pair.problem, request.seed);
  const PairTimes times{matched.ms_keypoints, matched.ms_matching};
  std::cout << PairText(matched.pair, estimate, times);
  if (!request.matches.empty()) WriteFileAtomically(request.matches, MatchesText(matched.pair.problem));
  if (!request.json.empty()) WriteFileAtomically(request.json, PairJson(matched.pair, estimate, times));
  if (!request.picture.empty()) {
    DrawInliers(request.images[0], request.images[1], matched.pair.problem.points, estimate.inliers,
                matched.pair.id + ", " + task, request.picture);
    std::cout << "picture: " << request.picture << std::endl;
  }
  if (estimate.MayBeChance())
    LogWarning("no more inliers than matches of unlike images would give: the images may share nothing");
  return estimate.status == Status::kOk ? kExitOk : kExitNoModel;
}

}  // namespace

int main(int argc, char** argv) {
  KeepFreedMemory();
  CLI::App app{
      "The model of two images: their motion with the focal length, or a fundamental, essential or homography matrix"};
  Request request;
  app.set_version_flag("--version", VersionText("diffsac_pair"));
  AddOptions(&app, &request);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::cerr << "diffsac_pair: " << error.what() << std::endl;
    return kExitBadInput;
  }
  try {
    InitLogging("", false);
    return Run(request);
  } catch (const std::exception& error) {
    std::cerr << "diffsac_pair: " << diffsac::MessageOf(error) << std::endl;
    return kExitBadInput;
  }
}
