#include "lab/images/estimate_photographs.h"

#include <chrono>
#include <cmath>
#include <set>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"
#include "lab/images/match_pair.h"

namespace diffsac {
namespace {

MatchIndices IndicesOf(const std::vector<DescriptorMatch>& matches) {
  MatchIndices indices(static_cast<Eigen::Index>(matches.size()), 2);
  for (std::size_t i = 0; i < matches.size(); ++i)
    indices.row(static_cast<Eigen::Index>(i)) << matches[i].first, matches[i].second;
  return indices;
}

/// What all pairs know of a length one alone does not move: the pair has had its say.
CameraPriorHint Held(CameraPriorHint hint, FocalSource from) {
  constexpr double kHeld = 2e-3;
  if (from == FocalSource::kPairs) hint.focal->log_sigma = kHeld;
  return hint;
}

/// The length of all pairs, with its own interval.
void TellPooled(const FocalPrior& pooled, int image, FocalEstimate* focal) {
  focal->focal_px[image] = pooled.focal;
  focal->low_px[image] = pooled.focal * std::exp(-pooled.log_sigma);
  focal->high_px[image] = pooled.focal * std::exp(pooled.log_sigma);
  focal->prior_focal_px[image] = pooled.focal;
  focal->prior_log_sigma[image] = pooled.log_sigma;
  focal->observable[image] = true;
}

/// One length is surer than two, and a model of it is one of two.
void EstimateOfCameras(const PhotographCameras& cameras, PairOptions options, ImagePair* pair) {
  Problem& problem = pair->example.problem;
  const bool unknown = !problem.cameras;
  for (int k = 0; k < 2 && unknown; ++k) {
    const auto image = static_cast<std::size_t>(pair->images[k]);
    (k == 0 ? problem.camera_prior1 : problem.camera_prior2) = Held(cameras.hints[image], cameras.from[image]);
    pair->hints_from[k] = cameras.from[image];
    pair->camera[k] = cameras.camera[image];
  }
  if (unknown && options.task == Task::kTwoFocals && pair->camera[0] == pair->camera[1])
    options.task = Task::kSharedFocal;
  try {
    EstimatePair(options, pair);
  } catch (const Error& error) {
    LogWarning(pair->example.id + ": " + error.what());
    pair->done = true;
  }
  for (int k = 0; k < 2 && unknown; ++k) {
    if (pair->hints_from[k] != FocalSource::kPairs || !pair->estimate.focal) continue;
    pair->estimate.focal_from[k] = FocalSource::kPairs;
    TellPooled(*cameras.hints[static_cast<std::size_t>(pair->images[k])].focal, k, &*pair->estimate.focal);
  }
}

/// Those that are done, or all, and chosen.
template <class Chosen>
void EstimateEach(const char* what, const PhotographCameras& cameras, const PairOptions& options,
                  const std::atomic<bool>& stop, const Chosen& chosen, std::vector<ImagePair>* pairs) {
  Progress progress(what, std::ssize(*pairs));
  ParallelFor(std::ssize(*pairs), options.threads, [&](std::int64_t i) {
    if (stop) return;
    if (chosen((*pairs)[i])) EstimateOfCameras(cameras, options, &(*pairs)[i]);
    progress.Advance();
  });
}

std::vector<FocalsOfPair> FocalsOf(const std::vector<ImagePair>& pairs) {
  std::vector<FocalsOfPair> focals;
  for (const ImagePair& pair : pairs)
    if (pair.done && pair.estimate.focal)
      focals.push_back({pair.images, *pair.estimate.focal,
                        !pair.estimate.MayBeChance() && !IsUndetermined(pair.estimate.diagnostics.degeneracy)});
  return focals;
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

std::vector<ImagePair> EstimatePairs(const ImageSource& source, const FeatureStore& store,
                                     const PhotographCameras& cameras, const PairOptions& options,
                                     const std::atomic<bool>& stop) {
  const std::vector<SourcePair>& pairs = source.scenes.at(0).pairs;
  std::vector<ImagePair> estimated(pairs.size());
  Progress progress("pairs", std::ssize(pairs));
  ForEachPair(store, pairs, options.threads, stop,
              [&](std::int64_t i, const ImageFeatures& first, const ImageFeatures& second) {
                using Clock = std::chrono::steady_clock;
                const auto start = Clock::now();
                MatchedPair matched = MatchPair(source, pairs[i], first, second, store.distance());
                ImagePair& pair = estimated[i];
                pair.example = std::move(matched.example);
                pair.matches = IndicesOf(matched.matches);
                pair.images = {pairs[i].image1, pairs[i].image2};
                pair.ms_matching = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
                EstimateOfCameras(cameras, options, &pair);
                progress.Advance();
              });
  return estimated;
}

void EstimateMatchedPairs(const PhotographCameras& cameras, const PairOptions& options, const std::atomic<bool>& stop,
                          std::vector<ImagePair>* pairs) {
  EstimateEach(
      "pairs", cameras, options, stop, [](const ImagePair&) { return true; }, pairs);
}

bool EstimateWithPooledFocals(const PairOptions& options, const std::atomic<bool>& stop, PhotographCameras* cameras,
                              std::vector<ImagePair>* pairs) {
  const std::vector<int> before = cameras->camera;
  if (options.task == Task::kTwoFocals) JoinCameras(FocalsOf(*pairs), cameras);
  const auto joined = [&](const ImagePair& pair) {
    const auto [i, j] = pair.images;
    return pair.done && before[i] != before[j] && cameras->camera[i] == cameras->camera[j];
  };
  if (cameras->camera != before) EstimateEach("pairs, of one camera", *cameras, options, stop, joined, pairs);
  if (stop) return false;
  PoolFocals(FocalsOf(*pairs), cameras);
  EstimateEach(
      "pairs, by the focal lengths of all", *cameras, options, stop, [](const ImagePair& pair) { return pair.done; },
      pairs);
  return !stop;
}

}  // namespace diffsac
