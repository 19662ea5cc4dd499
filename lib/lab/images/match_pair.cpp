#include "lab/images/match_pair.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <map>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/colmap/database.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/images/detection.h"
#include "lab/images/given_matches.h"
#include "lab/images/image_cameras.h"
#include "lab/images/photographs.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// Equal correspondences say one thing: the one with the best ratio stays. Keeps the order.
std::vector<DescriptorMatch> WithoutRepeats(const std::vector<DescriptorMatch>& matches, const ImageFeatures& first,
                                            const ImageFeatures& second) {
  using Position = std::array<double, 4>;
  std::map<Position, std::size_t> best;
  const auto position = [&](const DescriptorMatch& m) {
    return Position{first.positions(m.first, 0), first.positions(m.first, 1), second.positions(m.second, 0),
                    second.positions(m.second, 1)};
  };
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const auto [entry, is_new] = best.try_emplace(position(matches[i]), i);
    if (!is_new && matches[i].ratio < matches[entry->second].ratio) entry->second = i;
  }
  std::vector<DescriptorMatch> kept;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (best.at(position(matches[i])) == i) kept.push_back(matches[i]);
  return kept;
}

void FillProblem(const SourceImage& image1, const SourceImage& image2, const ImageFeatures& first,
                 const ImageFeatures& second, std::vector<DescriptorMatch>* kept, Problem* into) {
  const PointMatrix positions1 = StraightPositions(image1.camera, first.positions),
                    positions2 = StraightPositions(image2.camera, second.positions);
  std::vector<DescriptorMatch>& matches = *kept;
  std::erase_if(matches, [&](const DescriptorMatch& match) {
    return !positions1.row(match.first).allFinite() || !positions2.row(match.second).allFinite();
  });
  Problem& problem = *into;
  const auto count = static_cast<Eigen::Index>(matches.size());
  problem.points.resize(count, 4);
  problem.snn_ratio.resize(count);
  MatchIndices rows(count, 2);
  for (Eigen::Index i = 0; i < count; ++i) {
    const DescriptorMatch& match = matches[i];
    problem.points.row(i) << positions1.row(match.first), positions2.row(match.second);
    problem.snn_ratio[i] = match.ratio;
    rows.row(i) << match.first, match.second;
  }
  problem.scale_rotation_changes = ScaleRotationChangesOf(first.frames, second.frames, rows);
  problem.size1 = first.size;
  problem.size2 = second.size;
  if (image1.camera && image2.camera) problem.cameras = CameraPair{image1.camera->K, image2.camera->K};
}

// The names of two images: by as much of their folders as tells them apart, as in a run on a folder of both.
std::array<std::string, 2> NamesOf(const std::string& path1, const std::string& path2) {
  const std::array<std::string, 2> names = {ImageName(path1), ImageName(path2)};
  if (names[0] != names[1] || path1 == path2) return names;
  const std::vector<fs::path> whole = {fs::absolute(path1).lexically_normal(), fs::absolute(path2).lexically_normal()};
  const auto within = [&](int k) { return whole[k].lexically_relative(CommonFolder(whole)).string(); };
  const auto told = PairNames(std::map<std::int64_t, std::string>{{1, within(0)}, {2, within(1)}});
  return {told.at(1), told.at(2)};
}

}  // namespace

PointMatrix StraightPositions(const std::optional<LensCamera>& camera, PointMatrix positions) {
  if (!camera || camera->IsStraight()) return positions;
  for (Eigen::Index i = 0; i < positions.rows(); ++i)
    positions.row(i) = camera->Undistort(positions.row(i).transpose()).transpose();
  return positions;
}

MatchedPair MatchPair(const ImageSource& source, const SourcePair& pair, const ImageFeatures& first,
                      const ImageFeatures& second, DescriptorDistance distance) {
  const SourceImage &image1 = source.images[pair.image1], &image2 = source.images[pair.image2];
  MatchedPair matched;
  matched.matches = WithoutRepeats(MatchMutually(first.descriptors, second.descriptors, distance), first, second);
  Example& example = matched.example;
  example.image1 = image1.name;
  example.image2 = image2.name;
  example.id = example.image1 + "-" + example.image2;
  FillProblem(image1, image2, first, second, &matched.matches, &example.problem);
  if (image1.pose && image2.pose) example.truth.motion = RelativeMotion(*image1.pose, *image2.pose);
  example.truth.homography = pair.homography;
  CompleteTruth(example.problem, &example.truth);
  return matched;
}

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

ImagePair MatchTwoImages(const std::string& path1, const std::string& path2, const FeatureOptions& options,
                         const GivenCalibration& calibration, int threads) {
  options.Check();
  const std::vector<std::string> paths = {path1, path2};
  for (const std::string& path : paths) RequireImage(path);
  const ImageCameras cameras(calibration, paths);
  ImagePair matched;
  auto start = Clock::now();
  std::vector<ImageFeatures> features(2);
  ParallelFor(2, threads, [&](std::int64_t i) { features[i] = FeaturesOf(paths[i], options); });
  matched.ms_keypoints = MillisecondsSince(start);
  cameras.WarnOfSizes({features[0].size, features[1].size});
  start = Clock::now();
  ImageSource source;
  const std::array<std::string, 2> names = NamesOf(path1, path2);
  for (std::size_t i = 0; i < 2; ++i)
    source.images.push_back({names[i], paths[i], cameras.Of(i, features[i].size), {}});
  matched.example = MatchPair(source, {0, 1, {}}, features[0], features[1], DistanceOf(options.kind)).example;
  matched.ms_matching = MillisecondsSince(start);
  if (!cameras.given()) {
    matched.example.problem.camera_prior1 = ExifHint(path1, features[0].size);
    matched.example.problem.camera_prior2 = ExifHint(path2, features[1].size);
  }
  return matched;
}

}  // namespace diffsac
