// Estimates the model of two images, or of every pair of a folder of photographs, by the functions of diffsac.h:
// keypoints, matches, estimates; a text and a picture, or a table, a page and a COLMAP database.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <opencv2/core/utility.hpp>

#include "diffsac/core/logging.h"
#include "diffsac/diffsac.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/process.h"
#include "lab/config/program.h"
#include "lab/config/progress.h"
#include "lab/config/report_script.h"
#include "lab/config/run_directory.h"
#include "lab/files/files.h"
#include "lab/images/exif_focal.h"
#include "lab/images/given_matches.h"
#include "lab/images/image_cameras.h"
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
Exit status: 0 a model (of many pairs, of one at least), 1 none, 2 bad input, 130 interrupted.
More: docs/two_view.md)";

struct Request {
  std::vector<std::string> images;
  std::string list, output = "pairs";
  bool overwrite = false, same_camera = false;
  std::optional<Task> task;
  std::string picture = "diffsac_pictures/matches.png", json, matches;
  GivenMatches given;
  GivenCalibration calibration;
  FeatureOptions features{.max_image_size = 3200};  // As COLMAP has it.
  PairOptions options;

  bool IsGiven() const { return !given.file.empty(); }
  bool Takes(Task other) const { return task == other; }
  /// Whose focal lengths are found, unless another task is asked for.
  bool FindsFocal() const { return task && FindsFocals(*task); }
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
  CLI::Option* list = app->add_option(
      "--list", request->list,
      "Only these pairs: a text file, two images a line. Without images beside it, of the images that it "
      "names (default: all pairs)");
  CLI::Option* matches = app->add_option(
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
           if (texts.size() > 2) throw CLI::ValidationError("--sizes", "expected one size, or two");
         },
         "Of --from-matches: the images' sizes, as 640x480, or one for each: 640x480,800x600 (default: unknown)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->needs(matches);
  AddCalibrationOptions(app, &request->calibration);
  app->add_flag("--same-camera", request->same_camera,
                "Without a calibration: one camera took all images, at one zoom (default: where EXIF data say so)");
  CLI::Option* features =
      app->add_option_function<std::string>(
             "--features",
             [request](const std::string& name) { request->features.kind = FromString<FeatureKind>(name); },
             "sift, rootsift, orb or, where LibTorch is installed, xfeat, of 4096 keypoints and 1600 pixels if not "
             "said "
             "otherwise (default: rootsift)")
          ->check(CLI::IsMember({"sift", "rootsift", "orb", "xfeat"}));
  CLI::Option* keypoints =
      app->add_option("--max-keypoints", request->features.max_keypoints, "The strongest of an image; 0: all")
          ->capture_default_str();
  CLI::Option* size = app->add_option("--max-image-size", request->features.max_image_size,
                                      "Reduce larger images to this side; 0: never")
                          ->capture_default_str();
  for (CLI::Option* of_images : {list, features, keypoints, size}) matches->excludes(of_images);
}

void AddEstimator(CLI::App* app, Request* request) {
  PairOptions& options = request->options;
  app->add_option_function<std::string>(
         "--task", [request](const std::string& name) { request->task = TaskFromString(name); },
         "essential, shared_focal (R, t and the focal length of both images, which EXIF data hint at), "
         "two_focals (with one for each image), fundamental, homography or, of points of a known scene, "
         "absolute_pose (default: essential with a calibration; without, shared_focal for images of one "
         "camera, else two_focals)")
      ->check(CLI::IsMember({"essential", "shared_focal", "two_focals", "fundamental", "homography", "absolute_pose"}));
  app->add_option_function<std::string>(
         "--guidance", [&options](const std::string& name) { options.guidance = FromString<Guidance>(name); },
         "What guides the samples of E, F and H: network (a network's probabilities and PROSAC together), none (PROSAC "
         "alone, as for scores and unknown focal lengths) or diffusion (default: network)")
      ->check(CLI::IsMember({"network", "none", "diffusion"}));
  app->add_option("--models", options.models_folder,
                  "A folder of networks to use instead of the library's (default: none)");
  app->add_option("--threshold-px", options.threshold_px,
                  "The most that an inlier's residual can be (default: 1; homographies 3, absolute poses 4)")
      ->check(NumberAbove(0));
  app->add_option("--max-iterations", options.max_iterations, "Most minimal samples (default: 1000)")
      ->check(NumberFrom(1));
  app->add_option("--min-iterations", options.min_iterations,
                  "Least minimal samples (default: 100; of unknown focal lengths all, of absolute poses 0)")
      ->check(NumberFrom(0));
  app->add_option("--confidence", options.confidence,
                  "The search ends when a better model would have been drawn with this probability (default: 0.9999)")
      ->check(NumberWithin(0.0, 1.0));
  app->add_option("--threads", options.threads, "Threads; 0: all cores")
      ->check(NumberWithin(0, 1024))
      ->capture_default_str();
  app->add_option("--seed", options.seed, "Of the search; every pair has the same")
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

bool IsManyGiven(const Request& request) { return request.IsGiven() && AreManyMatches(request.given.file); }

bool IsOnePair(const Request& request) {
  if (request.IsGiven()) return !IsManyGiven(request);
  return request.list.empty() && AreTwoFiles(request.images);
}

void CheckGivenMatches(const CLI::App& app, Request* request) {
  if (!request->IsGiven()) return;
  const bool images = !request->images.empty(), many = IsManyGiven(*request);
  if (images && (many || request->Takes(Task::kAbsolutePose) || !AreTwoFiles(request->images)))
    throw Error("--from-matches: expected no images, or the two that the matches of one pair are of");
  if (!images && !request->picture.empty() && app.count("--picture") > 0)
    throw Error("--picture: with --from-matches a picture needs the two images");
  if (!images) request->picture.clear();
}

// What belongs to the other kind of run is a mistake.
void CheckUse(const CLI::App& app, Request* request) {
  CheckGivenMatches(app, request);
  // As XFeat's authors have it.
  if (request->features.kind == FeatureKind::kXFeat) {
    if (app.count("--max-keypoints") == 0) request->features.max_keypoints = 4096;
    if (app.count("--max-image-size") == 0) request->features.max_image_size = 1600;
  }
  const bool given = request->IsGiven();
  if (request->Takes(Task::kAbsolutePose) && !given)
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
Task TaskOf(const Request& request, const std::vector<SourceImage>& images, bool calibrated) {
  if (request.same_camera && (calibrated || (request.task && !request.Takes(Task::kSharedFocal))))
    throw Error("--same-camera is for images without a calibration, whose focal length is looked for");
  for (const auto& [task, name] :
       {std::pair(Task::kEssential, "an essential matrix"), {Task::kAbsolutePose, "an absolute pose"}})
    if (request.Takes(task) && !calibrated)
      throw Error(std::string(name) + " needs --calibration, --cameras or --focal");
  if (request.FindsFocal() && calibrated)
    throw Error(ToString(*request.task) + " finds the focal length: it takes no --calibration, --cameras or --focal");
  if (request.task) return *request.task;
  if (calibrated) return Task::kEssential;
  const bool one = images.empty() ? request.same_camera : CamerasOfPhotographs(images, {}, request.same_camera).IsOne();
  return one ? Task::kSharedFocal : Task::kTwoFocals;
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

/// Goes over to two focal lengths where EXIF data say one and two explain many more matches: a digital zoom.
void TryTwoFocals(PairOptions options, ImagePair* pair) {
  constexpr double kManyMore = 1.25;
  constexpr int kLeastMore = 10;
  options.task = Task::kTwoFocals;
  ImagePair two = *pair;
  EstimatePair(options, &two);
  const int one = pair->estimate.num_inliers, both = two.estimate.num_inliers;
  if (!two.estimate.ok() || both - one < kLeastMore || both < kManyMore * one) return;
  LogWarning("EXIF data say that one camera took both images at one zoom, but two focal lengths explain " +
             std::to_string(both) + " matches and one explains " + std::to_string(one) +
             ": taken as of two zooms; --same-camera takes one");
  *pair = std::move(two);
}

/// Of a folder. Who knows better than EXIF data and the matches has something to gain.
void SaySeveralCameras(const PhotographCameras& cameras) {
  if (cameras.AreDivided())
    std::cout
        << "images of one size are taken as of several cameras, for neither EXIF data nor the matches say that it "
           "is one: if it is, --same-camera is surer\n";
}

/// Who knows better than EXIF data has something to gain.
void SayTwoCameras(const Request& request, const Problem& problem) {
  const auto sides = [](const ImageSize& size) { return std::minmax(size.width, size.height); };
  if (problem.task == Task::kTwoFocals && !request.task && problem.size1.known() &&
      sides(problem.size1) == sides(problem.size2))
    std::cout << "taken as of two cameras, for no EXIF data say that it is one: if it is, --same-camera is surer\n";
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
  inputs.insert(inputs.end(), {request.list, request.given.file});
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

/// Keypoints and matches of two images, or matches that are given.
ImagePair MatchedPairOf(const Request& request) {
  if (!request.IsGiven())
    return MatchTwoImages(request.images[0], request.images[1], request.features, request.calibration,
                          request.options.threads);
  return (request.Takes(Task::kAbsolutePose) ? ReadScenePoints : ReadMatches)(request.given, request.calibration);
}

void WarnOfPair(const PairEstimate& estimate) {
  if (estimate.diagnostics.cheirality_failure_ratio > kMostBehind)
    LogWarning("many of the matches that fit lie behind a camera: an image may be mirrored");
  else if (estimate.MayBeChance())
    LogWarning(
        "no more inliers than matches of unlike images would give: the images may share nothing. Look at the picture; "
        "take images that show more of the same from nearer places, or more keypoints (--max-keypoints 0)");
}

void WritePair(const ImagePair& pair, const Request& request, const std::string& first, const std::string& second) {
  const Problem& problem = pair.example.problem;
  if (!request.matches.empty()) WriteFileAtomically(request.matches, MatchesText(problem));
  if (!request.json.empty()) {
    Json json = PairJson(pair, first, second);
    json["correspondences"] = CorrespondencesJson(problem);
    WriteFileAtomically(request.json, JsonText(json));
  }
  if (request.picture.empty()) return;
  DrawInliers(first, second, problem.points, pair.estimate.inliers, pair.example.id + ", " + ToString(problem.task),
              request.picture);
  std::cout << "picture: " << request.picture << std::endl;
}

int RunOne(Request request) {
  std::vector<SourceImage> images;
  for (const std::string& path : request.images) images.push_back({"", path, {}, {}});
  PairOptions& options = request.options;
  options.task = TaskOf(request, images, request.calibration.IsGiven());
  RefuseInputs(request);
  for (const std::string& file : {request.picture, request.json, request.matches}) RequireFolderOf(file);
  if (options.threads > 0) cv::setNumThreads(options.threads);
  if (request.IsGiven() && FindsFocals(options.task) && request.given.sizes.empty()) throw Error(kNeedsSizes);
  ImagePair pair = MatchedPairOf(request);
  if (options.task == Task::kSharedFocal) WarnOfZoom(pair.example.problem);
  EstimatePair(options, &pair);
  if (options.task == Task::kSharedFocal && !request.task && !request.same_camera) TryTwoFocals(options, &pair);
  std::cout << PairText(pair);
  SayTwoCameras(request, pair.example.problem);
  request.images.resize(2);
  WritePair(pair, request, request.images[0], request.images[1]);
  WarnOfPair(pair.estimate);
  return pair.estimate.ok() ? kExitOk : kExitNoModel;
}

std::string KeypointsFolder(const Request& request) { return (fs::path(request.output) / ".keypoints").string(); }

/// Keypoints that are left in a folder are those of a run that was interrupted: the next one goes on with them.
void RefuseResults(const Request& request) {
  std::error_code code;
  std::vector<std::string> files;
  for (const char* name : {kPosesFile, kReportFile, kPairsJson, kDatabaseFile})
    files.push_back((fs::path(request.output) / name).string());
  RefuseInputsAsOutputs(files, InputsOf(request));
  if (request.overwrite || fs::exists(KeypointsFolder(request), code)) return;
  for (const std::string& file : files)
    if (fs::exists(file, code))
      throw Error(request.output + ": holds results already (" + fs::path(file).filename().string() +
                  "); --overwrite replaces them, --output DIR writes elsewhere");
}

/// Photographs, the cameras that must be found, and what is estimated of the pairs.
struct Work {
  Photographs photographs;
  PhotographCameras cameras;
  std::unique_ptr<FeatureStore> store;  ///< Null: the pairs came with their matches.
  std::vector<ImagePair> pairs;
};

int EndInterrupted(const Work& work, const Request& request, const std::string& what) {
  LogWarning("interrupted: " + what +
             (work.store ? "; the same command goes on with the keypoints that are kept in " + KeypointsFolder(request)
                         : std::string()));
  return kExitInterrupted;
}

/// Finds the keypoints and estimates the pairs. False when it was stopped before that.
bool EstimateImages(const ImageCameras& cameras, const Request& request, Work* work) {
  cv::setNumThreads(1);  // one image a thread
  ImageSource& source = work->photographs.source;
  work->store = std::make_unique<FeatureStore>(source, request.features, "", KeypointsFolder(request));
  if (!PreparePhotographs(cameras, request.options.threads, stop_requested, work->store.get(), &source)) return false;
  std::vector<ImageSize> sizes;
  for (int i = 0; i < std::ssize(source.images); ++i) sizes.push_back(work->store->SizeOf(i));
  work->cameras = CamerasOfPhotographs(source.images, sizes, request.same_camera);
  work->pairs = EstimatePairs(source, *work->store, work->cameras, request.options, stop_requested);
  return true;
}

void WarnOfZooms(const Work& work) {
  const auto zoomed = std::count_if(work.pairs.begin(), work.pairs.end(),
                                    [](const ImagePair& pair) { return pair.done && IsZoomed(pair.example.problem); });
  if (zoomed > 0)
    LogWarning("EXIF data say of " + std::to_string(zoomed) +
               " pairs that their focal lengths differ, and shared_focal takes one for both images: --task two_focals "
               "takes both");
}

/// What follows the first estimates, of either kind of pairs.
int FinishPairs(const Request& request, Work* work) {
  const auto done = std::count_if(work->pairs.begin(), work->pairs.end(), [](const auto& pair) { return pair.done; });
  if (done == 0) return EndInterrupted(*work, request, "no pair was matched");
  if (request.options.task == Task::kSharedFocal) WarnOfZooms(*work);
  const bool finds = FindsFocals(request.options.task),
             settled =
                 !finds || EstimateWithPooledFocals(request.options, stop_requested, &work->cameras, &work->pairs);
  if (finds) SaySeveralCameras(work->cameras);
  WritePhotographResults({work->photographs, work->cameras, work->store.get(), request.options, request.output},
                         work->pairs, std::cout);
  const auto asked = std::ssize(work->pairs);
  if (done < asked || !settled)
    return EndInterrupted(*work, request, std::to_string(done) + " of " + std::to_string(asked) + " pairs are done");
  if (work->store) work->store->RemoveCache();
  const bool any =
      std::any_of(work->pairs.begin(), work->pairs.end(), [](const auto& pair) { return pair.estimate.ok(); });
  return any ? kExitOk : kExitNoModel;
}

int RunPhotographs(Request request) {
  Work work;
  work.photographs = ListPhotographs(request.images, request.list);
  request.options.task = TaskOf(request, work.photographs.source.images, request.calibration.IsGiven());
  std::vector<std::string> paths;
  for (const SourceImage& image : work.photographs.source.images) paths.push_back(image.path);
  const ImageCameras cameras(request.calibration, paths);
  RefuseResults(request);
  const RunLock lock(request.output);
  MakeWritableFolder(request.output);
  if (!EstimateImages(cameras, request, &work))
    return EndInterrupted(work, request,
                          "the keypoints of " + std::to_string(work.store->CountPrepared()) + " of " +
                              std::to_string(paths.size()) + " images are found, no pair is matched");
  return FinishPairs(request, &work);
}

/// Pairs that came with their matches, as photographs.
int RunGiven(Request request) {
  if (request.Takes(Task::kAbsolutePose))
    throw Error(request.given.file + ": --task absolute_pose takes a text file of points x y X Y Z");
  GivenPairs given =
      ReadManyMatches(request.given, request.calibration, !request.task || request.Takes(Task::kEssential));
  const Problem& first = given.set.pairs.front().problem;
  request.options.task = TaskOf(request, {}, first.cameras.has_value());
  if (FindsFocals(request.options.task) && !first.size1.known()) throw Error(kNeedsSizes);
  if (given.of_others > 0)
    LogWarning(request.given.file + ": " + std::to_string(given.of_others) +
               " pairs of cameras without a prior focal length are left out: --task two_focals takes all");
  RefuseResults(request);
  const RunLock lock(request.output);
  MakeWritableFolder(request.output);
  const std::string name = fs::path(request.given.file).lexically_normal().stem().string();
  GivenPhotographs photographs = PhotographsOf(std::move(given), name.empty() || name == "." ? "matches" : name);
  Work work{std::move(photographs.photographs), {}, nullptr, std::move(photographs.pairs)};
  work.cameras = CamerasOfPhotographs(work.photographs.source.images, photographs.sizes, request.same_camera);
  EstimateMatchedPairs(work.cameras, request.options, stop_requested, &work.pairs);
  return FinishPairs(request, &work);
}

int Run(const CLI::App& app, Request request) {
  CheckUse(app, &request);
  InitLogging("", false);
  if (IsOnePair(request)) return RunOne(request);
  StopOnSignals();
  return request.IsGiven() ? RunGiven(request) : RunPhotographs(request);
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
