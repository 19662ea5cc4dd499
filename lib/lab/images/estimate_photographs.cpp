#include "lab/images/estimate_photographs.h"

#include <chrono>
#include <cmath>
#include <set>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/progress.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/images/feature_store.h"

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

void EstimatePair(const SourcePair& images, const PhotographCameras& cameras, const PairEstimation& estimation,
                  EstimatedPair* pair) {
  const std::array<int, 2> of = {images.image1, images.image2};
  Problem& problem = pair->example.problem;
  if (!problem.cameras) {
    problem.camera_prior1 = Held(cameras.hints[of[0]], cameras.from[of[0]]);
    problem.camera_prior2 = Held(cameras.hints[of[1]], cameras.from[of[1]]);
  }
  // One length is surer than two, and a model of it is one of two.
  const bool one =
      estimation.task == Task::kTwoFocals && !problem.cameras && cameras.camera[of[0]] == cameras.camera[of[1]];
  SetTask(one ? Task::kSharedFocal : estimation.task, estimation.inlier_threshold_px, &pair->example);
  pair->estimate = estimation.method.Run(problem, estimation.seed);
  SetTask(estimation.task, estimation.inlier_threshold_px, &pair->example);
  std::optional<FocalEstimate>& focal = pair->estimate.focal;
  for (int k = 0; k < 2; ++k) {
    if (!problem.cameras) pair->camera[k] = cameras.camera[of[k]];
    const FocalSource from = cameras.from[of[k]];
    pair->focal_from[k] = from == FocalSource::kPairs ? from : SourceOfFocal(problem, focal, k, from);
    if (from == FocalSource::kPairs && focal) TellPooled(*cameras.hints[of[k]].focal, k, &*focal);
  }
  pair->done = true;
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

std::vector<EstimatedPair> EstimatePairs(const ImageSource& source, const FeatureStore& store,
                                         const PhotographCameras& cameras, const PairEstimation& estimation,
                                         const std::atomic<bool>& stop) {
  const std::vector<SourcePair>& pairs = source.scenes.at(0).pairs;
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
                EstimatePair(pairs[i], cameras, estimation, &pair);
                progress.Advance();
              });
  return estimated;
}

std::vector<EstimatedPair> EstimateGivenPairs(const ImageSource& source, GivenPairs given,
                                              const PhotographCameras& cameras, const PairEstimation& estimation,
                                              const std::atomic<bool>& stop) {
  std::vector<EstimatedPair> estimated(given.set.pairs.size());
  Progress progress("pairs", static_cast<std::int64_t>(estimated.size()));
  ParallelFor(static_cast<std::int64_t>(estimated.size()), estimation.threads, [&](std::int64_t i) {
    if (stop) return;
    EstimatedPair& pair = estimated[i];
    pair.example = std::move(given.set.pairs[i]);
    if (!given.set.match_indices.empty()) pair.matches = std::move(given.set.match_indices[i]);
    EstimatePair(source.scenes.at(0).pairs[i], cameras, estimation, &pair);
    progress.Advance();
  });
  return estimated;
}

bool EstimateWithPooledFocals(const ImageSource& source, const PairEstimation& estimation,
                              const std::atomic<bool>& stop, PhotographCameras* cameras,
                              std::vector<EstimatedPair>* pairs) {
  const std::vector<SourcePair>& images = source.scenes.at(0).pairs;
  std::vector<std::array<int, 2>> of_done;
  std::vector<std::size_t> done;
  for (std::size_t i = 0; i < pairs->size(); ++i) {
    if (!(*pairs)[i].done) continue;
    done.push_back(i);
    of_done.push_back({images[i].image1, images[i].image2});
  }
  const auto estimates = [&] {
    std::vector<Estimate> all;
    for (const std::size_t i : done) all.push_back((*pairs)[i].estimate);
    return all;
  };
  const auto estimate_again = [&](const char* what, const auto& chosen) {
    Progress progress(what, static_cast<std::int64_t>(done.size()));
    ParallelFor(static_cast<std::int64_t>(done.size()), estimation.threads, [&](std::int64_t i) {
      if (stop) return;
      if (chosen(of_done[i])) EstimatePair(images[done[i]], *cameras, estimation, &(*pairs)[done[i]]);
      progress.Advance();
    });
  };
  const std::vector<int> before = cameras->camera;
  if (estimation.task == Task::kTwoFocals) JoinCameras(of_done, estimates(), cameras);
  if (cameras->camera != before)
    estimate_again("pairs, of one camera", [&](const std::array<int, 2>& of) {
      return before[of[0]] != before[of[1]] && cameras->camera[of[0]] == cameras->camera[of[1]];
    });
  if (stop) return false;
  PoolFocals(of_done, estimates(), cameras);
  estimate_again("pairs, by the focal lengths of all", [](const auto&) { return true; });
  return !stop;
}

}  // namespace diffsac
