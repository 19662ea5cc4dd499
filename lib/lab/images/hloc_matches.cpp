// Matches made by hloc's matchers (SuperGlue, LightGlue, LoFTR, ...) as pairs.
#include <algorithm>
#include <filesystem>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/colmap/database.h"
#include "lab/images/given_pairs.h"
#include "lab/images/hloc_files.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// The one file of this kind in a folder.
std::string OnlyFile(const std::string& folder, HlocKind kind, const char* what, const char* option) {
  std::vector<std::string> found;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code))
    if (entry.path().extension() == ".h5" && KindOfHlocFile(entry.path().string()) == kind)
      found.push_back(entry.path().string());
  if (found.size() == 1) return found[0];
  std::sort(found.begin(), found.end());
  std::string names;
  for (const std::string& file : found) names += (names.empty() ? "" : ", ") + fs::path(file).filename().string();
  throw Error(folder + ": expected one .h5 file with hloc's " + what + ", found " +
              (found.empty() ? "none" : std::to_string(found.size()) + " (" + names + ")") + "; name it with " +
              option);
}

}  // namespace

GivenPairs ReadHlocPairs(const PairsRequest& request) {
  std::error_code code;
  const bool is_folder = fs::is_directory(request.input, code);
  const std::string matches =
      is_folder ? OnlyFile(request.input, HlocKind::kMatches, "matches", "--input") : request.input;
  const std::string folder = fs::absolute(matches).parent_path().string();
  if (!fs::is_regular_file(matches, code)) throw Error(matches + ": no such file or folder");
  const std::string features = request.options.import_descriptors.empty()
                                   ? OnlyFile(folder, HlocKind::kFeatures, "features", "--import-descriptors")
                                   : request.options.import_descriptors;
  HlocFiles files = ReadHlocFiles(features, matches);
  if (files.repeated > 0)
    LogInfo(matches + ": " + std::to_string(files.repeated) + " pairs repeat others the other way round: left out");
  std::size_t bad_images = 0;
  for (const HlocImage& image : files.images) {
    if (image.problem.empty()) continue;
    LogWarning("left out: " + image.problem);
    ++bad_images;
  }
  for (const std::string& problem : files.bad_pairs) LogWarning("left out: " + problem);
  if (const std::size_t pairs = files.bad_pairs.size() + static_cast<std::size_t>(files.of_bad_images);
      bad_images + pairs > 0)
    LogWarning(std::to_string(bad_images) + " of " + std::to_string(files.images.size()) + " images and " +
               std::to_string(pairs) + " of " + std::to_string(pairs + files.pairs.size()) + " pairs were left out");
  const std::optional<LensCamera> camera = CameraOf(request.calibration);
  std::map<std::int64_t, std::string> image_files;
  for (std::size_t i = 0; i < files.images.size(); ++i)
    image_files[static_cast<std::int64_t>(i)] = files.images[i].name;
  const auto names = PairNames(image_files);
  GivenPairs given;
  for (const auto& [id, name] : names) given.files[name] = image_files.at(id);
  CorrespondenceSet& set = given.set;
  for (HlocPair& pair : files.pairs) {
    const HlocImage &image1 = files.images[pair.image1], &image2 = files.images[pair.image2];
    Example example;
    example.image1 = names.at(static_cast<std::int64_t>(pair.image1));
    example.image2 = names.at(static_cast<std::int64_t>(pair.image2));
    example.id = example.image1 + "-" + example.image2;
    Problem& problem = example.problem;
    problem.points.resize(pair.matches.rows(), 4);
    for (Eigen::Index i = 0; i < pair.matches.rows(); ++i)
      problem.points.row(i) << image1.keypoints.row(pair.matches(i, 0)), image2.keypoints.row(pair.matches(i, 1));
    problem.scored = pair.scores.size() > 0;
    if (problem.scored) problem.snn_ratio = 1.0 - pair.scores.array();
    problem.scale_rotation_changes = ScaleRotationChangesOf(image1.frames, image2.frames, pair.matches);
    problem.size1 = image1.size;
    problem.size2 = image2.size;
    if (camera) problem.cameras = CameraPair{camera->K, camera->K};
    set.pairs.push_back(std::move(example));
    set.match_indices.push_back(std::move(pair.matches));
  }
  KeepAllScaleRotationChangesOrNone(&set);
  return given;
}

namespace {

PrepareResult WriteHloc(const PairsRequest& request, const std::atomic<bool>& stop) {
  PrepareResult result;
  const std::string name = !request.scene.empty()            ? request.scene
                           : fs::is_directory(request.input) ? FolderName(request.input)
                                                             : fs::path(request.input).stem().string();
  WriteScene(
      request, name, [&] { return ReadHlocPairs(request).set; }, stop, &result);
  return result;
}

const Registered<ImageFormat> kHloc("hloc", {.takes_calibration = true, .write = WriteHloc});

}  // namespace
}  // namespace diffsac
