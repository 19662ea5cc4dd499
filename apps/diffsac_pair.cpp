// Estimates the model of two images, or of every pair of a folder of photographs: keypoints, matches, one row of an
// experiment; a text and a picture, or a table, a page and a COLMAP database.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <opencv2/core/utility.hpp>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/presets.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/number_checks.h"
#include "lab/config/paths.h"
#include "lab/config/process.h"
#include "lab/config/program.h"
#include "lab/config/run_directory.h"
#include "lab/config/run_lock.h"
#include "lab/config/terminal_log.h"
#include "lab/eval/evaluate.h"
#include "lab/eval/report_script.h"
#include "lab/eval/selection.h"
#include "lab/files/files.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/images/exif_focal.h"
#include "lab/images/given_matches.h"
#include "lab/images/image_cameras.h"
#include "lab/images/image_source.h"
#include "lab/images/match_pair.h"
#include "lab/images/pair_text.h"
#include "lab/images/photograph_results.h"
#include "lab/images/pictures.h"

namespace {

using namespace diffsac;
namespace fs = std::filesystem;

constexpr const char* kFooter = R"(Examples:
  diffsac_pair first.jpg second.jpg                        pose and focal lengths; a picture
  diffsac_pair first.jpg second.jpg --same-camera          one focal length for both, which is surer
  diffsac_pair first.jpg second.jpg --focal 2900           pose; the principal point is the image's middle
  diffsac_pair first.jpg second.jpg --calibration K1.txt,K2.txt --json pair.json
  diffsac_pair photos --output pairs                       all pairs of a folder: poses.csv, report.html, database.db
  diffsac_pair 'photos/IMG_*.jpg' --cameras sparse/0       the cameras of a COLMAP model
  diffsac_pair --list pairs.txt                            a line for each pair: a.jpg b.jpg
  diffsac_pair --from-matches m.csv --calibration K.txt    your own matches: x1 y1 x2 y2 and, if known, ratio or score
  diffsac_pair --from-matches matches.h5 --focal 2900      hloc's, the features beside them; or database.db, or a folder
  diffsac_pair --task absolute_pose --from-matches points.csv --calibration K.txt      x y X Y Z: the camera's pose
  diffsac_pair --method                                    says which estimators there are
Exit status: 0 a model (of many pairs, of one at least), 1 none, 2 bad input, 130 interrupted.
More: docs/two_view.md)";

struct Request {
  std::vector<std::string> images;
  std::string list, output = "pairs";
  bool overwrite = false, same_camera = false;
  std::string task, config_path, method, picture = "diffsac_pictures/matches.png", json, matches;
  std::vector<std::string> assignments;
  GivenMatches given;
  GivenCalibration calibration;
  FeatureOptions features{.max_image_size = 3200};  // As COLMAP has it.
  double threshold_px = 0.0;                        // 0: the task's
  EstimatorContext context;
  std::uint64_t seed = 0;
  bool only_rows = false;
};

/// "640x480".
ImageSize SizeFromText(const std::string& text) {
  ImageSize size;
  int used = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &size.width, &size.height, &used) != 2 || !size.known() ||
      used != std::ssize(text))
    throw CLI::ValidationError("--sizes", "expected sizes such as 640x480, found " + text);
  return size;
}

void AddInput(CLI::App* app, Request* request) {
  app->add_option("images", request->images,
                  "Two images; or photographs of which every pair is estimated: a folder, three images or more, "
                  "patterns in quotes ('photos/*.jpg')");
  app->add_option("--list", request->list,
                  "Only these pairs: a text file, two images a line. Without images beside it, of the images that it "
                  "names (default: all pairs)");
  app->add_option(
      "--from-matches", request->given.file,
      "Instead of images, or with two that are drawn: matches in a text file, CSV or as --matches writes "
      "them (.npy and .npz too, SuperGlue's among them), a line each: x1 y1 x2 y2 [ratio [log_size angle]] "
      "in pixels; with a header in any order, and "
      "score (0 to 1, higher is better) in the place of ratio. Many pairs, as photographs: a folder of such "
      "files, hloc's matches (.h5) with the features beside them, a COLMAP database (.db). Of absolute_pose: "
      "x y X Y Z [ratio] a line (with a header u, v, x, y, z)");
  app->add_option_function<std::vector<std::string>>(
         "--sizes",
         [request](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) request->given.sizes.push_back(SizeFromText(text));
         },
         "Of --from-matches: the images' sizes, as 640x480, or one for each: 640x480,800x600 (default: unknown)")
      ->delimiter(',')
      ->allow_extra_args(false);
  AddCalibrationOptions(app, &request->calibration);
  app->add_flag("--same-camera", request->same_camera,
                "Without a calibration: one camera took all images, at one zoom (default: where EXIF data say so)");
  app->add_option_function<std::string>(
         "--features", [request](const std::string& name) { request->features.kind = FromString<FeatureKind>(name); },
         "sift, rootsift, orb or, where LibTorch is installed, xfeat, of 4096 keypoints and 1600 pixels if not said "
         "otherwise (default: rootsift)")
      ->check(CLI::IsMember({"sift", "rootsift", "orb", "xfeat"}));
  app->add_option("--max-keypoints", request->features.max_keypoints, "The strongest of an image; 0: all")
      ->capture_default_str();
  app->add_option("--max-image-size", request->features.max_image_size, "Reduce larger images to this side; 0: never")
      ->capture_default_str();
}

void AddEstimator(CLI::App* app, Request* request) {
  app->add_option("--task", request->task,
                  "essential, shared_focal (R, t and the focal length of both images, which EXIF data hint at), "
                  "two_focals (with one for each image), fundamental, homography or, of points of a known scene, "
                  "absolute_pose (default: essential with a calibration; without, shared_focal for images of one "
                  "camera, else two_focals)")
      ->check(CLI::IsMember({"essential", "shared_focal", "two_focals", "fundamental", "homography", "absolute_pose"}));
  app->add_option("--config", request->config_path,
                  "Estimators to choose from (default: configs/pair/TASK.yaml beside the program)");
  app->add_option("--method", request->method,
                  "The estimator, a row of --config; without a value: says which there are (default: the first, "
                  "learned_prosac, which draws by a network and runs no reverse process; without a "
                  "calibration: prosac_marginalised, without a network)")
      ->expected(0, 1);
  app->add_option("--set", request->assignments, "key.path=value, overrides the configuration (default: nothing)")
      ->allow_extra_args(false);
  app->add_option("--checkpoint", request->context.checkpoint_override,
                  "Replaces the estimator's network (default: the row's)");
  app->add_option("--threshold-px", request->threshold_px,
                  "The most that an inlier's residual can be (default: 1; homographies 3)")
      ->check(NumberAbove(0));
  app->add_option("--device", request->context.device, "auto, cpu, cuda or cuda:INDEX")->capture_default_str();
  app->add_option("--threads", request->context.threads, "Threads; 0: all cores")
      ->check(NumberWithin(0, 1024))
      ->capture_default_str();
  app->add_option("--seed", request->seed, "Of the search; every pair has the same")
      ->check(NumberFrom(0))
      ->capture_default_str();
}

void AddOutput(CLI::App* app, Request* request) {
  app->add_option("--picture", request->picture, "Two images: where the picture goes; empty: none")
      ->capture_default_str();
  app->add_option("--json", request->json, "Two images: also everything as JSON in this file (default: none)");
  app->add_option("--matches", request->matches,
                  "Two images: also the matches in this file, a line each: x1 y1 x2 y2 ratio, and of the keypoints "
                  "log(size2 / size1) and angle2 - angle1 in radians (default: none)");
  app->add_option("--output", request->output, "Photographs: the folder of the results")->capture_default_str();
  app->add_flag("--overwrite", request->overwrite, "Photographs: replaces results that are there (default: no)");
}

bool IsManyGiven(const Request& request) { return !request.given.file.empty() && AreManyMatches(request.given.file); }

bool IsOnePair(const Request& request) {
  if (!request.given.file.empty()) return !IsManyGiven(request);
  return request.list.empty() && AreTwoFiles(request.images);
}

void CheckGivenMatches(const CLI::App& app, Request* request) {
  if (request->given.file.empty()) {
    if (app.count("--sizes") > 0) throw Error("--sizes is for --from-matches");
    return;
  }
  for (const char* option : {"--list", "--features", "--max-keypoints", "--max-image-size"})
    if (app.count(option) > 0) throw Error(std::string(option) + " is for images, not for --from-matches");
  if (request->given.sizes.size() > 2) throw Error("--sizes: expected one size, or two");
  if (!request->images.empty() && !AreTwoFiles(request->images))
    throw Error("--from-matches: expected no images, or the two that the matches are of");
  if (IsManyGiven(*request) && !request->images.empty())
    throw Error("--from-matches: images are for the matches of one pair");
  if (request->task == "absolute_pose" && !request->images.empty())
    throw Error("--from-matches: points of --task absolute_pose are drawn on no images");
  if (request->images.empty() && !request->picture.empty() && app.count("--picture") > 0)
    throw Error("--picture: with --from-matches a picture needs the two images");
  if (request->images.empty()) request->picture.clear();
}

// What belongs to the other kind of run is a mistake.
void CheckUse(const CLI::App& app, Request* request) {
  request->only_rows = app.count("--method") > 0 && request->method.empty();
  if (request->only_rows) return;
  CheckGivenMatches(app, request);
  // As XFeat's authors have it.
  if (request->features.kind == FeatureKind::kXFeat) {
    if (app.count("--max-keypoints") == 0) request->features.max_keypoints = 4096;
    if (app.count("--max-image-size") == 0) request->features.max_image_size = 1600;
  }
  const bool given = !request->given.file.empty();
  if (request->task == "absolute_pose" && !given)
    throw Error("--task absolute_pose is for --from-matches, with points x y X Y Z of a known scene");
  if (!given && request->list.empty() && request->images.empty())
    throw Error("expected two images, or a folder of photographs");
  std::error_code code;
  if (!given && request->list.empty() && request->images.size() == 1 && fs::is_regular_file(request->images[0], code))
    throw Error(request->images[0] + ": expected two images, or a folder of photographs");
  const bool one = IsOnePair(*request);
  const std::vector<std::string> of_two = {"--picture", "--json", "--matches"}, of_many = {"--output", "--overwrite"};
  for (const std::string& option : one ? of_many : of_two)
    if (app.count(option) > 0 && !(option == "--picture" && request->picture.empty()))
      throw Error(option +
                  (one ? " is for folders and lists of photographs" : " is for two images, not for many pairs"));
}

/// `images`: without a calibration, those of which EXIF data may say that one camera took them.
std::string TaskOf(const Request& request, const std::vector<SourceImage>& images, bool calibrated) {
  if (request.same_camera && (calibrated || (!request.task.empty() && request.task != "shared_focal")))
    throw Error("--same-camera is for images without a calibration, whose focal length is looked for");
  if (request.task == "essential" && !calibrated && !request.only_rows)
    throw Error("an essential matrix needs --calibration, --cameras or --focal");
  if (request.task == "absolute_pose" && !calibrated && !request.only_rows)
    throw Error("an absolute pose needs --calibration, --cameras or --focal");
  if (!request.task.empty() && FindsFocals(TaskFromString(request.task)) && calibrated)
    throw Error(request.task + " finds the focal length: it takes no --calibration, --cameras or --focal");
  if (!request.task.empty()) return request.task;
  if (calibrated) return "essential";
  const bool one = images.empty() ? request.same_camera : CamerasOfPhotographs(images, {}, request.same_camera).IsOne();
  return one ? "shared_focal" : "two_focals";
}

/// One focal length for both images, where EXIF data say that there are two.
bool IsZoomed(const Problem& problem) {
  const std::optional<FocalPrior>&first = problem.camera_prior1.focal, &second = problem.camera_prior2.focal;
  return first && second && std::abs(std::log(first->focal / second->focal)) > 2.0 * kExifLogSigma;
}

void WarnOfZoom(const Problem& problem) {
  if (!IsZoomed(problem)) return;
  LogWarning("EXIF data say that the focal lengths are " +
             std::to_string(std::lround(problem.camera_prior1.focal->focal)) + " and " +
             std::to_string(std::lround(problem.camera_prior2.focal->focal)) +
             " pixels, and shared_focal takes one for both images: --task two_focals takes both");
}

std::ptrdiff_t InliersOf(const Estimate& estimate) {
  return std::count(estimate.inliers.begin(), estimate.inliers.end(), 1);
}

/// Goes over to two focal lengths where EXIF data say one and two explain many more matches: a digital zoom.
void TryTwoFocals(const std::function<Estimate(const Problem&)>& search, double threshold_px, Example* pair,
                  Estimate* estimate) {
  constexpr double kManyMore = 1.25;
  constexpr std::ptrdiff_t kLeastMore = 10;
  Example of_two = *pair;
  SetTask(Task::kTwoFocals, threshold_px, &of_two);
  Estimate two = search(of_two.problem);
  const auto one = InliersOf(*estimate), more = InliersOf(two) - one;
  if (two.status != Status::kOk || more < kLeastMore ||
      static_cast<double>(more) < (kManyMore - 1.0) * static_cast<double>(one))
    return;
  LogWarning("EXIF data say that one camera took both images at one zoom, but two focal lengths explain " +
             std::to_string(one + more) + " matches and one explains " + std::to_string(one) +
             ": taken as of two zooms; --same-camera takes one");
  *pair = std::move(of_two);
  *estimate = std::move(two);
}

/// Of a folder. Who knows better than EXIF data and the matches has something to gain.
void SaySeveralCameras(const PhotographCameras& cameras) {
  if (cameras.AreDivided())
    std::cout
        << "images of one size are taken as of several cameras, for neither EXIF data nor the matches say that it "
           "is one: if it is, --same-camera is surer\n";
}

/// Who knows better than EXIF data has something to gain.
void SayTwoCameras(const Request& request, const std::string& task, const Problem& problem) {
  const auto sides = [](const ImageSize& size) { return std::minmax(size.width, size.height); };
  if (task == "two_focals" && request.task.empty() && problem.size1.known() &&
      sides(problem.size1) == sides(problem.size2))
    std::cout << "taken as of two cameras, for no EXIF data say that it is one: if it is, --same-camera is surer\n";
}

std::string RowsText(const ExperimentOptions& experiment) {
  std::string text;
  for (const EstimatorRow& row : experiment.methods) text += (text.empty() ? "" : ", ") + row.name;
  return text;
}

ExperimentOptions AllRows(const Request& request, const std::string& task) {
  EvalRequest rows;
  rows.config_path = request.config_path.empty() ? SharedFile("configs/pair/" + task + ".yaml")
                                                 : NamedConfiguration(request.config_path, "configs/pair");
  rows.assignments = request.assignments;
  ExperimentOptions experiment = ReadRequest(rows);
  experiment.seed = request.seed;
  if (experiment.methods.empty()) throw Error(rows.config_path + ": no methods");
  return experiment;
}

/// The experiment with the one row that runs.
ExperimentOptions ChosenRow(const Request& request, const std::string& task) {
  ExperimentOptions experiment = AllRows(request, task);
  std::vector<std::string> names;
  for (const EstimatorRow& row : experiment.methods) names.push_back(row.name);
  const std::string name = request.method.empty() ? names.front() : request.method;
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw Error("--method " + name + ": no such row; there are " + RowsText(experiment));
  SelectEstimators({name}, &experiment);
  experiment.threads = request.context.threads;
  return experiment;
}

int ListRows(const Request& request) {
  const std::string task = TaskOf(request, {}, request.calibration.IsGiven());
  std::cout << "--task " << task << ":\n";
  for (const EstimatorRow& row : AllRows(request, task).methods)
    std::cout << "  " << row.name << (row.label.empty() || row.label == row.name ? "" : ": " + row.label) << "\n";
  return kExitOk;
}

double ThresholdOf(const Request& request, const std::string& task) {
  return request.threshold_px > 0.0 ? request.threshold_px : DefaultThreshold(TaskFromString(task));
}

void RequireFolderOf(const std::string& file) {
  const fs::path folder = fs::path(file).parent_path();
  std::error_code code;
  if (!folder.empty() && folder.filename() != kPictureFolder && !fs::is_directory(folder, code))
    throw Error(file + ": there is no folder " + folder.string());
}

/// Of both kinds of run.
std::vector<std::string> InputsOf(const Request& request) {
  std::vector<std::string> inputs = request.calibration.Inputs();
  inputs.insert(inputs.end(),
                {request.list, request.given.file, request.config_path, request.context.checkpoint_override});
  return inputs;
}

/// Before any work: what is written must not be what is read.
void RefuseInputs(const Request& request) {
  std::vector<std::string> inputs = InputsOf(request);
  inputs.insert(inputs.end(), request.images.begin(), request.images.end());
  RefuseInputsAsOutputs({request.picture, request.json, request.matches}, inputs);
  if (!request.picture.empty()) CheckPictureName(request.picture);
}

constexpr const char* kNeedsSizes =
    "--from-matches: focal lengths are found about the images' middles: give --sizes, a calibration, or --task "
    "fundamental";

/// Networks have learned what ratios say, not what scores do.
void SuitScores(const Problem& problem, Request* request) {
  if (problem.scored && request->method.empty() && request->task != "absolute_pose")
    request->method = "prosac_marginalised";
}

int RunTwo(Request request) {
  std::vector<SourceImage> images;
  for (const std::string& path : request.images) images.push_back({"", path, {}, {}});
  const std::string task = TaskOf(request, images, request.calibration.IsGiven());
  RefuseInputs(request);
  for (const std::string& file : {request.picture, request.json, request.matches}) RequireFolderOf(file);
  if (request.context.threads > 0) cv::setNumThreads(request.context.threads);
  const bool given = !request.given.file.empty();
  if (given && FindsFocals(TaskFromString(task)) && request.given.sizes.empty()) throw Error(kNeedsSizes);
  MatchedImages matched;
  if (given) matched = (task == "absolute_pose" ? ReadScenePoints : ReadMatches)(request.given, request.calibration);
  SuitScores(matched.pair.problem, &request);
  const ExperimentOptions experiment = ChosenRow(request, task);
  const auto method = MakeEstimator(experiment.methods.front().config, TaskFromString(task), request.context);
  if (!given)
    matched = MatchTwoImages(request.images[0], request.images[1], request.features, request.calibration,
                             request.context.threads);
  SetTask(TaskFromString(task), ThresholdOf(request, task), &matched.pair);
  if (task == "shared_focal") WarnOfZoom(matched.pair.problem);
  const auto search = [&](const Problem& problem) { return method->Run(problem, request.seed); };
  Estimate estimate = search(matched.pair.problem);
  if (task == "shared_focal" && request.task.empty() && !request.same_camera)
    TryTwoFocals(search, ThresholdOf(request, task), &matched.pair, &estimate);
  const PairTimes times{matched.ms_keypoints, matched.ms_matching};
  request.images.resize(2);
  const PairRun run{request.images[0], request.images[1], experiment.methods.front().name, request.seed};
  std::cout << PairText(matched.pair, estimate, times);
  SayTwoCameras(request, task, matched.pair.problem);
  if (!request.matches.empty()) WriteFileAtomically(request.matches, MatchesText(matched.pair.problem));
  if (!request.json.empty()) WriteFileAtomically(request.json, PairJson(matched.pair, estimate, times, run));
  if (!request.picture.empty()) {
    DrawInliers(request.images[0], request.images[1], matched.pair.problem.points, estimate.inliers,
                matched.pair.id + ", " + task, request.picture);
    std::cout << "picture: " << request.picture << std::endl;
  }
  if (estimate.cheirality_failure_ratio > kMostBehind)
    LogWarning("many of the matches that fit lie behind a camera: an image may be mirrored");
  else if (estimate.MayBeChance())
    LogWarning(
        "no more inliers than matches of unlike images would give: the images may share nothing. Look at the picture; "
        "take images that show more of the same from nearer places, or more keypoints (--max-keypoints 0)");
  return estimate.status == Status::kOk ? kExitOk : kExitNoModel;
}

std::string KeypointsFolder(const Request& request) { return (fs::path(request.output) / ".keypoints").string(); }

/// Keypoints that are left in a folder are those of a run that was interrupted: the next one goes on with them.
void RefuseResults(const Request& request) {
  std::error_code code;
  const bool finished =
      fs::exists(fs::path(request.output) / kPosesFile, code) && !fs::exists(KeypointsFolder(request), code);
  std::vector<std::string> files;
  for (const char* name : {kPosesFile, kReportFile, kEstimatesFile, kDatabaseFile, "config.yaml"})
    files.push_back((fs::path(request.output) / name).string());
  RefuseInputsAsOutputs(files, InputsOf(request));
  const bool ours = ProgramOfRun(request.output) == kPairProgram || fs::exists(KeypointsFolder(request), code);
  for (const std::string& file : files)
    if (!ours && !request.overwrite && fs::exists(file, code))
      throw Error(file + ": is there already; --overwrite replaces it, --output DIR writes elsewhere");
  if (finished && !request.overwrite)
    throw Error(request.output + ": holds results already; --overwrite replaces them, --output DIR writes elsewhere");
}

/// How many pairs are done.
std::ptrdiff_t CountDone(const std::vector<EstimatedPair>& pairs) {
  return std::count_if(pairs.begin(), pairs.end(), [](const EstimatedPair& pair) { return pair.done; });
}

/// The exit status of pairs of which one at least has a model, or none.
int StatusOf(const std::vector<EstimatedPair>& pairs) {
  const bool any = std::any_of(pairs.begin(), pairs.end(), [](const EstimatedPair& pair) {
    return pair.done && pair.estimate.status == Status::kOk;
  });
  return any ? kExitOk : kExitNoModel;
}

int EndInterrupted(const Request& request, const std::string& what) {
  LogWarning("interrupted: " + what + "; the same command goes on with the keypoints that are kept in " +
             KeypointsFolder(request));
  return kExitInterrupted;
}

int RunMany(const Request& request) {
  Photographs photographs = ListPhotographs(request.images, request.list);
  const std::string task = TaskOf(request, photographs.source.images, request.calibration.IsGiven());
  std::vector<std::string> paths;
  for (const SourceImage& image : photographs.source.images) paths.push_back(image.path);
  const ImageCameras cameras(request.calibration, paths);
  ExperimentOptions experiment = ChosenRow(request, task);
  experiment.name = photographs.source.scenes.front().name;
  experiment.title = experiment.name + ", " + task;
  const auto method = MakeEstimator(experiment.methods.front().config, experiment.task, request.context);
  RefuseResults(request);
  const RunLock lock(request.output);
  MakeWritableFolder(request.output);
  cv::setNumThreads(1);  // one image a thread
  FeatureStore store(photographs.source, request.features, "", KeypointsFolder(request));
  const int threads = request.context.threads;
  if (!PreparePhotographs(cameras, threads, stop_requested, &store, &photographs.source))
    return EndInterrupted(request, "the keypoints of " + std::to_string(store.CountPrepared()) + " of " +
                                       std::to_string(paths.size()) + " images are found, no pair is matched");
  const double threshold_px = ThresholdOf(request, task);
  const PairEstimation estimation{*method, experiment.task, threshold_px, request.seed, threads};
  std::vector<ImageSize> sizes;
  for (std::size_t i = 0; i < paths.size(); ++i) sizes.push_back(store.SizeOf(static_cast<int>(i)));
  PhotographCameras unknown = CamerasOfPhotographs(photographs.source.images, sizes, request.same_camera);
  std::vector<EstimatedPair> pairs = EstimatePairs(photographs.source, store, unknown, estimation, stop_requested);
  const bool settled = !FindsFocals(experiment.task) ||
                       EstimateWithPooledFocals(photographs.source, estimation, stop_requested, &unknown, &pairs);
  const auto done = CountDone(pairs), asked = std::ssize(pairs);
  if (done == 0) return EndInterrupted(request, "no pair was matched");
  const auto zoomed = std::count_if(pairs.begin(), pairs.end(), [](const EstimatedPair& pair) {
    return pair.done && IsZoomed(pair.example.problem);
  });
  if (task == "shared_focal" && zoomed > 0)
    LogWarning("EXIF data say of " + std::to_string(zoomed) +
               " pairs that their focal lengths differ, and shared_focal takes one for both images: --task two_focals "
               "takes both");
  const int status = StatusOf(pairs);
  if (FindsFocals(experiment.task)) SaySeveralCameras(unknown);
  WritePhotographResults(photographs, store, unknown, std::move(pairs), experiment, threshold_px, request.output,
                         std::cout);
  if (done < asked || !settled)
    return EndInterrupted(request, std::to_string(done) + " of " + std::to_string(asked) + " pairs are done");
  store.RemoveCache();
  return status;
}

/// Pairs that came with their matches, as photographs.
int RunGiven(Request request) {
  const bool poses = request.task.empty() || request.task == "essential";
  if (request.task == "absolute_pose")
    throw Error(request.given.file + ": --task absolute_pose takes a text file of points x y X Y Z");
  GivenPairs given = ReadManyMatches(request.given, request.calibration, poses);
  const std::vector<Example>& read = given.set.pairs;
  const bool calibrated = read.front().problem.cameras.has_value();
  const std::string task = TaskOf(request, {}, calibrated);
  if (FindsFocals(TaskFromString(task)) && !read.front().problem.size1.known()) throw Error(kNeedsSizes);
  if (given.of_others > 0)
    LogWarning(request.given.file + ": " + std::to_string(given.of_others) +
               " pairs of cameras without a prior focal length are left out: --task two_focals takes all");
  SuitScores(read.front().problem, &request);
  ExperimentOptions experiment = ChosenRow(request, task);
  experiment.name = fs::path(request.given.file).lexically_normal().stem().string();
  if (experiment.name.empty() || experiment.name == ".") experiment.name = "matches";
  experiment.title = experiment.name + ", " + task;
  const auto method = MakeEstimator(experiment.methods.front().config, experiment.task, request.context);
  RefuseResults(request);
  const RunLock lock(request.output);
  MakeWritableFolder(request.output);
  const ImageSource source = SourceOf(given, experiment.name);
  const double threshold_px = ThresholdOf(request, task);
  const PairEstimation estimation{*method, experiment.task, threshold_px, request.seed, request.context.threads};
  PhotographCameras unknown = CamerasOfPhotographs(source.images, {}, request.same_camera);
  const auto files = given.files;
  std::vector<EstimatedPair> pairs = EstimateGivenPairs(source, std::move(given), unknown, estimation, stop_requested);
  if (FindsFocals(experiment.task)) EstimateWithPooledFocals(source, estimation, stop_requested, &unknown, &pairs);
  const auto done = CountDone(pairs), asked = std::ssize(pairs);
  if (done == 0) return kExitInterrupted;
  const int status = StatusOf(pairs);
  WriteGivenResults(std::move(pairs), files, experiment.name, experiment, threshold_px, request.output, std::cout);
  if (done < asked || stop_requested) {
    LogWarning("interrupted: " + std::to_string(done) + " of " + std::to_string(asked) + " pairs are done");
    return kExitInterrupted;
  }
  return status;
}

int Run(const CLI::App& app, Request request) {
  CheckUse(app, &request);
  InitLogging("", false);
  if (request.only_rows) return ListRows(request);
  if (IsOnePair(request)) return RunTwo(request);
  StopOnSignals();
  return request.given.file.empty() ? RunMany(request) : RunGiven(request);
}

}  // namespace

int main(int argc, char** argv) {
  KeepFreedMemory();
  CLI::App app{
      "The model of two images, or of every pair of photographs: their motion with the focal lengths, or a "
      "fundamental, "
      "essential or homography matrix"};
  Request request;
  app.set_version_flag("--version", VersionText(kPairProgram));
  app.footer(kFooter);
  AddInput(&app, &request);
  AddEstimator(&app, &request);
  AddOutput(&app, &request);
  return RunProgram(kPairProgram, &app, argc, argv, [&] { return Run(app, request); });
}
