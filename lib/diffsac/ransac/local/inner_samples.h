#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/ransac/policies.h"
#include "diffsac/ransac/scores/score.h"
#include "diffsac/ransac/scores/scorer.h"

namespace diffsac {

/// Least squares on the points within `threshold` of *model; false, leaving *model, when they determine none.
template <MinimalModel Model>
bool FitInliers(const Scorer<Model>& scorer, double threshold, typename Model::Parameters* model) {
  const Eigen::VectorXd weights = (scorer.Residuals(*model).array() <= threshold).template cast<double>();
  return FitAgain(scorer, weights, model);
}

/// `samples` times, least squares on min(7γ, |I|/2) (at least γ) of the start's inliers I, then four rounds of least
/// squares on the points within 2, 5/3, 4/3 and 1 times `threshold`. Returns the best model met, the start itself when
/// none scores higher; every fit is added to *fits.
template <MinimalModel Model>
ScoredModel<Model> FitInnerSamples(const Scorer<Model>& scorer, const Score& score, double threshold, int samples,
                                   const ScoredModel<Model>& start, Rng rng, int* fits) {
  constexpr int kRounds = 4;
  constexpr double kWidest = 2.0;
  ScoredModel<Model> best = start;
  const auto offer = [&](const typename Model::Parameters& model, const Eigen::VectorXd& residuals) {
    const double value = scorer(model, residuals, score, best.score);
    if (value > best.score) best = {model, value};
  };
  Eigen::VectorXd residuals = scorer.Residuals(start.model), weights(scorer.size());
  std::vector<int> inliers;
  for (int i = 0; i < scorer.size(); ++i)
    if (residuals[i] <= threshold) inliers.push_back(i);
  const int available = static_cast<int>(inliers.size());
  if (available <= Model::kMinimalSize) return best;
  const int size = std::clamp(available / 2, Model::kMinimalSize + 0, 7 * Model::kMinimalSize);
  std::vector<int> chosen(size);
  for (int sample = 0; sample < samples; ++sample) {
    rng.Distinct(available, size, chosen.data());
    weights.setZero();
    for (int position : chosen) weights[inliers[position]] = 1.0;
    typename Model::Parameters model = start.model;
    ++*fits;
    if (!FitAgain(scorer, weights, &model)) continue;
    scorer.Residuals(model, 0, scorer.size(), residuals.data());
    offer(model, residuals);
    for (int round = 0; round < kRounds; ++round) {
      const double factor = kWidest + (1.0 - kWidest) * round / (kRounds - 1);
      weights = (residuals.array() <= factor * threshold).template cast<double>();
      ++*fits;
      if (!FitAgain(scorer, weights, &model)) break;
      scorer.Residuals(model, 0, scorer.size(), residuals.data());
      offer(model, residuals);
    }
  }
  return best;
}

/// Inner samples look at no more points than hold so many inliers, and at so many points at least.
inline constexpr int kPartInliers = 150;
inline constexpr int kPartPoints = 500;

/// How many of `size` points, `inliers` of them inliers, inner samples look at; all where that would save little.
inline int PartSize(int size, int inliers) {
  const double part = std::max<double>(kPartPoints, std::ceil(static_cast<double>(kPartInliers) * size / inliers));
  return 2.0 * part <= size ? static_cast<int>(part) : size;
}

/// Inner sampling of locally optimised RANSAC (Chum, Matas, Kittler, DAGM 2003) by FitInnerSamples. Where there are
/// many points a random part of them is looked at (as Lebeda, Matas, Chum, "Fixing the locally optimized RANSAC", BMVC
/// 2012, bound the inliers of a fit), so that the cost does not grow with their number; what comes out is fitted to the
/// inliers among all points, while its score rises. Returns the best model met by the score on all points, the start
/// itself when none scores higher; every fit is added to *fits.
template <MinimalModel Model>
ScoredModel<Model> OptimizeByInnerSamples(const Scorer<Model>& scorer, const Score& score, double threshold,
                                          int samples, const ScoredModel<Model>& start, const Rng& rng, int* fits) {
  constexpr int kRounds = 4;
  const int inliers = static_cast<int>((scorer.Residuals(start.model).array() <= threshold).count());
  if (inliers <= Model::kMinimalSize) return start;
  const int size = PartSize(scorer.size(), inliers);
  if (size == scorer.size()) return FitInnerSamples(scorer, score, threshold, samples, start, rng, fits);

  std::vector<int> rows(size);
  Rng part_rng = rng.Fork("part");
  part_rng.Distinct(scorer.size(), size, rows.data());
  std::sort(rows.begin(), rows.end());
  const PointMatrix points = scorer.points()(rows, Eigen::all);
  const Scorer<Model> part(points, scorer.prior().Of(rows), /*with_score_to_beat=*/false);
  const ScoredModel<Model> from = {start.model, part(start.model, score)};
  typename Model::Parameters model = FitInnerSamples(part, score, threshold, samples, from, rng, fits).model;
  ScoredModel<Model> best = start;
  double last = scorer(model, score, best.score);
  if (last > best.score) best = {model, last};
  for (int round = 0; round < kRounds; ++round) {
    ++*fits;
    if (!FitInliers(scorer, threshold, &model)) break;
    const double value = scorer(model, score, best.score);
    if (value > best.score) best = {model, value};
    if (round > 0 && !(value > last)) break;
    last = value;
  }
  return best;
}

}  // namespace diffsac
