// The matches of a COLMAP database, whoever made them, as pairs.
#include "lab/colmap/database.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/colmap/lens.h"
#include "lab/images/given_matches.h"
#include "lab/images/image_features.h"
#include "lab/images/match_pair.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// What pairs need of an image.
struct MatchedImage {
  std::string name;
  ImageSize size;
  Eigen::Matrix3d K;
  PointMatrix keypoints;          // of a calibrated pair: without distortion; NaN where there is no such place
  PointMatrix frames;             // as ColmapDatabase::KeypointFrames
  ColmapDescriptors descriptors;  // only for ratios
  std::string problem;            // why it cannot be used; empty: it can
};

// Pairs of one scene: of cameras that are all calibrated, or not.
class SceneOfPairs {
 public:
  SceneOfPairs(const ColmapDatabase& database, const PairsRequest& request, bool calibrated)
      : database_(database), request_(request), calibrated_(calibrated), names_(PairNames(database)) {}

  std::vector<ColmapPair> pairs;
  bool verified = false;  // Of two_view_geometries.

  CorrespondenceSet Read();

 private:
  const MatchedImage& Image(std::int64_t id);
  void ReadImage(std::int64_t id, MatchedImage* image) const;
  void AddPair(const ColmapPair& pair, CorrespondenceSet* set);
  void AddRatios(CorrespondenceSet* set);

  const ColmapDatabase& database_;
  const PairsRequest& request_;
  bool calibrated_;
  std::map<std::int64_t, std::string> names_;
  std::map<std::int64_t, MatchedImage> images_;
  std::int64_t left_out_ = 0;  // matches
  std::int64_t bad_images_ = 0;
};

const MatchedImage& SceneOfPairs::Image(std::int64_t id) {
  const auto [found, is_new] = images_.try_emplace(id);
  MatchedImage& image = found->second;
  if (is_new) {
    try {
      ReadImage(id, &image);
    } catch (const Error& error) {
      LogWarning(std::string("left out: ") + error.what());
      image.problem = error.what();
      ++bad_images_;
    }
  }
  return image;
}

void SceneOfPairs::ReadImage(std::int64_t id, MatchedImage* read) const {
  MatchedImage& image = *read;
  const ColmapCamera& camera = database_.CameraOf(id);
  std::optional<LensCamera> lens;
  if (calibrated_) lens = CameraOfColmap(camera, database_.path() + ": camera of " + database_.NameOf(id));
  image.name = names_.at(id);
  image.size = camera.size;
  if (lens) image.K = lens->K;
  image.keypoints = StraightPositions(lens, database_.Keypoints(id).array() - 0.5);
  image.frames = database_.KeypointFrames(id);
  if (request_.ratios) {
    image.descriptors = database_.Descriptors(id);
    if (image.descriptors.rows() == 0)
      throw Error(database_.path() + ": " + database_.NameOf(id) + " has no descriptors, which --ratios needs");
  }
}

void SceneOfPairs::AddPair(const ColmapPair& pair, CorrespondenceSet* set) {
  const MatchedImage &image1 = Image(pair.image1), &image2 = Image(pair.image2);
  for (const MatchedImage* image : {&image1, &image2})
    if (!image->problem.empty()) throw Error(image->problem);
  MatchIndices matches = database_.Matches(pair, verified);
  Example example;
  example.image1 = image1.name;
  example.image2 = image2.name;
  example.id = image1.name + "-" + image2.name;
  Problem& problem = example.problem;
  problem.size1 = image1.size;
  problem.size2 = image2.size;
  if (calibrated_) problem.cameras = CameraPair{image1.K, image2.K};
  problem.points.resize(matches.rows(), 4);
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < matches.rows(); ++i) {
    problem.points.row(count) << image1.keypoints.row(matches(i, 0)), image2.keypoints.row(matches(i, 1));
    matches.row(count) = matches.row(i);
    count += problem.points.row(count).allFinite() ? 1 : 0;
  }
  left_out_ += matches.rows() - count;
  problem.points.conservativeResize(count, 4);
  matches.conservativeResize(count, 2);
  problem.scale_rotation_changes = ScaleRotationChangesOf(image1.frames, image2.frames, matches);
  set->pairs.push_back(std::move(example));
  set->match_indices.push_back(std::move(matches));
}

void SceneOfPairs::AddRatios(CorrespondenceSet* set) {
  ParallelFor(static_cast<std::int64_t>(pairs.size()), request_.options.threads, [&](std::int64_t i) {
    const auto unit = [&](std::int64_t image) {
      DescriptorMatrix rows = images_.at(image).descriptors.cast<float>();
      rows.rowwise().normalize();
      return rows;
    };
    set->pairs[i].problem.snn_ratio = SnnRatios(unit(pairs[i].image1), unit(pairs[i].image2), set->match_indices[i]);
  });
}

CorrespondenceSet SceneOfPairs::Read() {
  CorrespondenceSet set;
  std::vector<ColmapPair> kept;
  std::string problem;
  for (const ColmapPair& pair : pairs) {
    try {
      AddPair(pair, &set);
      kept.push_back(pair);
    } catch (const Error& error) {
      if (problem.empty()) problem = error.what();
      // An image's problem is told once.
      if (Image(pair.image1).problem.empty() && Image(pair.image2).problem.empty())
        LogWarning(std::string("left out: ") + error.what());
    }
  }
  if (kept.empty()) throw Error(problem);
  if (kept.size() < pairs.size())
    LogWarning(database_.path() + ": " + std::to_string(bad_images_) + " images and " +
               std::to_string(pairs.size() - kept.size()) + " of " + std::to_string(pairs.size()) +
               " pairs were left out");
  pairs = std::move(kept);
  if (left_out_ > 0)
    LogInfo(database_.path() + ": left out " + std::to_string(left_out_) +
            " matches of keypoints that no camera without distortion sees");
  if (request_.ratios) AddRatios(&set);
  KeepAllScaleRotationChangesOrNone(&set);
  return set;
}

// Cameras without a prior focal length have COLMAP's guess, which is no calibration: COLMAP verifies their pairs by
// fundamental matrices. Files hold a calibration for all pairs or for none, so that mixed ones become two scenes.
PrepareResult WriteColmapDatabase(const PairsRequest& request, const std::atomic<bool>& stop) {
  const ColmapDatabase database(request.input);
  SceneOfPairs known(database, request, true), unknown(database, request, false);
  for (const ColmapPair& pair : database.MatchedPairs()) {
    const bool calibrated =
        database.CameraOf(pair.image1).has_prior_focal_length && database.CameraOf(pair.image2).has_prior_focal_length;
    (calibrated ? known : unknown).pairs.push_back(pair);
  }
  if (known.pairs.empty() && unknown.pairs.empty())
    throw Error(request.input + ": it holds no matches (colmap exhaustive_matcher finds some)");
  const std::string name = request.scene.empty() ? fs::path(request.input).stem().string() : request.scene;
  const bool mixed = !known.pairs.empty() && !unknown.pairs.empty();
  PrepareResult result;
  for (auto* scene : {&known, &unknown}) {
    if (scene->pairs.empty()) continue;
    const bool calibrated = scene == &known;
    if (!calibrated)
      LogInfo(request.input + ": " + std::to_string(scene->pairs.size()) +
              " pairs of cameras without a prior focal length: for task fundamental");
    const char* suffix = !mixed ? "" : calibrated ? "_calibrated" : "_uncalibrated";
    const std::string folder = (fs::path(request.output) / (name + suffix)).string();
    RefuseInputsInScene(request, folder);
    if (!request.options.overwrite && fs::exists(fs::path(folder) / "matches.h5")) {
      LogInfo(folder + ": already there");
      result.already_there += 1;
      continue;
    }
    const CorrespondenceSet set = scene->Read();
    result.finished = !stop;
    if (stop) continue;
    WriteCorrespondences(folder, set);
    LogInfo(folder + ": " + std::to_string(set.pairs.size()) + " pairs");
    result.written += 1;
  }
  return result;
}

}  // namespace

GivenPairs ReadColmapPairs(const std::string& path, bool calibrated) {
  const ColmapDatabase database(path);
  PairsRequest request;
  request.input = path;
  SceneOfPairs scene(database, request, calibrated);
  std::vector<ColmapPair> pairs = database.MatchedPairs();
  scene.verified = pairs.empty();
  if (pairs.empty()) pairs = database.MatchedPairs(true);
  if (pairs.empty()) throw Error(path + ": it holds no matches (colmap exhaustive_matcher finds some)");
  for (const ColmapPair& pair : pairs)
    if (!calibrated || (database.CameraOf(pair.image1).has_prior_focal_length &&
                        database.CameraOf(pair.image2).has_prior_focal_length))
      scene.pairs.push_back(pair);
  GivenPairs given;
  given.of_others = pairs.size() - scene.pairs.size();
  if (scene.pairs.empty()) return given;
  given.set = scene.Read();
  const auto names = PairNames(database);
  for (const auto& [id, image] : database.images()) given.files[names.at(id)] = image.name;
  return given;
}

namespace {

const Registered<ImageFormat> kColmapDatabase("colmap_database", {.takes_ratios = true, .write = WriteColmapDatabase});

}  // namespace
}  // namespace diffsac
