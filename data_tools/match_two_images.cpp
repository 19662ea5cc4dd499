#include "data_tools/match_two_images.h"

#include <chrono>

#include "data_tools/exif_focal.h"
#include "data_tools/match_pair.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

ImageFeatures FeaturesOf(const std::string& path, const FeatureOptions& options) {
  ImageFeatures features = ExtractFeatures(path, options);
  if (features.positions.rows() == 0) throw Error(path + ": no keypoints: the image is without texture");
  return features;
}

CameraHint HintOf(const std::string& path, const ImageSize& size) {
  CameraHint hint;
  if (const auto focal = ExifFocalPx(path, size)) hint.focal = FocalPrior{*focal, kExifLogSigma};
  return hint;
}

}  // namespace

MatchedImages MatchTwoImages(const std::string& path1, const std::string& path2, const FeatureOptions& options,
                             const GivenCalibration& calibration) {
  options.Check();
  ImageSource source;
  const std::optional<LensCamera> camera = CameraOf(calibration);
  for (const std::string& path : {path1, path2}) source.images.push_back({ImageName(path), path, camera, {}});
  MatchedImages matched;
  auto start = Clock::now();
  const ImageFeatures first = FeaturesOf(path1, options), second = FeaturesOf(path2, options);
  matched.ms_keypoints = MillisecondsSince(start);
  start = Clock::now();
  matched.pair = MatchPair(source, {0, 1, {}}, first, second, DistanceOf(options.kind)).example;
  matched.ms_matching = MillisecondsSince(start);
  if (!camera) {
    matched.pair.problem.hint1 = HintOf(path1, first.size);
    matched.pair.problem.hint2 = HintOf(path2, second.size);
  }
  return matched;
}

}  // namespace diffsac
