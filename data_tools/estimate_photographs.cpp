#include "data_tools/estimate_photographs.h"

#include <chrono>
#include <set>

#include "data_tools/pair_features.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/lab/progress.h"
#include "diffsac/problem/pair_truth.h"

namespace diffsac {
namespace {

MatchIndices IndicesOf(const std::vector<DescriptorMatch>& matches) {
  MatchIndices indices(static_cast<Eigen::Index>(matches.size()), 2);
  for (std::size_t i = 0; i < matches.size(); ++i)
    indices.row(static_cast<Eigen::Index>(i)) << matches[i].first, matches[i].second;
  return indices;
}

// One K and images of several sizes: most likely some of them were turned, or taken by another camera.
void WarnOfSizes(const ImageSource& source, const FeatureStore& store, const std::vector<int>& images) {
  std::set<std::pair<int, int>> sizes;
  for (const int i : images) {
    const auto& camera = source.images[i].camera;
    if (!camera || camera->size.known()) continue;
    const ImageSize& size = store.SizeOf(i);
    // A focal length alone takes each image's own middle.
    if (camera->K(0, 2) != 0.5 * (size.width - 1)) sizes.insert({size.width, size.height});
  }
  if (sizes.size() > 1)
    LogWarning("one calibration for images of " + std::to_string(sizes.size()) +
               " sizes: --calibration takes one for each, and --focal alone takes each image's middle");
}

}  // namespace

bool PreparePhotographs(const ImageCameras& cameras, int threads, const std::atomic<bool>& stop, FeatureStore* store,
                        ImageSource* source) {
  std::vector<SourcePair>& pairs = source->scenes.at(0).pairs;
  std::set<int> used;
  for (const SourcePair& pair : pairs) used.insert({pair.image1, pair.image2});
  const std::vector<int> images(used.begin(), used.end());
  std::vector<std::string> problems;
  if (!store->PrepareAll(images, threads, stop, &problems)) return false;
  std::set<int> left_out;
  for (std::size_t k = 0; k < images.size(); ++k) {
    SourceImage& image = source->images[images[k]];
    try {
      if (!problems[k].empty()) throw Error(problems[k]);
      image.camera = cameras.Of(static_cast<std::size_t>(images[k]), store->SizeOf(images[k]));
    } catch (const Error& error) {
      LogWarning(std::string("left out: ") + error.what());
      source->left_out.push_back({image.name, error.what()});
      left_out.insert(images[k]);
    }
  }
  std::erase_if(
      pairs, [&](const SourcePair& pair) { return left_out.contains(pair.image1) || left_out.contains(pair.image2); });
  if (pairs.empty())
    throw Error("no pair of images is left" +
                (source->left_out.empty() ? std::string() : ": " + source->left_out[0].problem));
  WarnOfSizes(*source, *store, images);
  return true;
}

std::vector<EstimatedPair> EstimatePairs(const ImageSource& source, const FeatureStore& store, bool calibrated,
                                         const PairEstimation& estimation, const std::atomic<bool>& stop) {
  const std::vector<SourcePair>& pairs = source.scenes.at(0).pairs;
  std::vector<CameraHint> hints(source.images.size());
  if (!calibrated)
    for (std::size_t i = 0; i < hints.size(); ++i)
      hints[i] = ExifHint(source.images[i].path, store.SizeOf(static_cast<int>(i)));
  std::vector<EstimatedPair> estimated(pairs.size());
  Progress progress("pairs", static_cast<std::int64_t>(pairs.size()));
  ForEachPair(store, pairs, estimation.threads, stop,
              [&](std::int64_t i, const ImageFeatures& first, const ImageFeatures& second) {
                using Clock = std::chrono::steady_clock;
                const auto start = Clock::now();
                MatchedPair matched = MatchPair(source, pairs[i], first, second, store.distance());
                EstimatedPair& pair = estimated[i];
                pair.example = std::move(matched.example);
                pair.matches = IndicesOf(matched.matches);
                pair.ms_matching = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
                pair.example.problem.hint1 = hints[pairs[i].image1];
                pair.example.problem.hint2 = hints[pairs[i].image2];
                SetTask(estimation.task, estimation.inlier_threshold_px, &pair.example);
                pair.estimate = estimation.method.Run(pair.example.problem, estimation.seed);
                pair.done = true;
                progress.Advance();
              });
  return estimated;
}

}  // namespace diffsac
