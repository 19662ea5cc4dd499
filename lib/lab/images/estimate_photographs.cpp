#include "lab/images/estimate_photographs.h"

#include <chrono>
#include <set>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"
#include "lab/images/feature_store.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {
namespace {

MatchIndices IndicesOf(const std::vector<DescriptorMatch>& matches) {
  MatchIndices indices(static_cast<Eigen::Index>(matches.size()), 2);
  for (std::size_t i = 0; i < matches.size(); ++i)
    indices.row(static_cast<Eigen::Index>(i)) << matches[i].first, matches[i].second;
  return indices;
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
  std::vector<ImageSize> sizes;
  for (const int image : images)
    if (!left_out.contains(image)) sizes.push_back(store->SizeOf(image));
  cameras.WarnOfSizes(sizes);
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
