#include "lab/images/match_two_images.h"

#include <chrono>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/images/detection.h"
#include "lab/images/image_cameras.h"
#include "lab/images/match_pair.h"

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

}  // namespace

MatchedImages MatchTwoImages(const std::string& path1, const std::string& path2, const FeatureOptions& options,
                             const GivenCalibration& calibration, int threads) {
  options.Check();
  const std::vector<std::string> paths = {path1, path2};
  for (const std::string& path : paths) RequireImage(path);
  const ImageCameras cameras(calibration, paths);
  MatchedImages matched;
  auto start = Clock::now();
  std::vector<ImageFeatures> features(2);
  ParallelFor(2, threads, [&](std::int64_t i) { features[i] = FeaturesOf(paths[i], options); });
  matched.ms_keypoints = MillisecondsSince(start);
  cameras.WarnOfSizes({features[0].size, features[1].size});
  start = Clock::now();
  ImageSource source;
  for (std::size_t i = 0; i < 2; ++i)
    source.images.push_back({ImageName(paths[i]), paths[i], cameras.Of(i, features[i].size), {}});
  matched.pair = MatchPair(source, {0, 1, {}}, features[0], features[1], DistanceOf(options.kind)).example;
  matched.ms_matching = MillisecondsSince(start);
  if (!cameras.given()) {
    matched.pair.problem.hint1 = ExifHint(path1, features[0].size);
    matched.pair.problem.hint2 = ExifHint(path2, features[1].size);
  }
  return matched;
}

}  // namespace diffsac
