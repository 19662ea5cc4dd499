#pragma once

#include <algorithm>
#include <vector>

#include "diffsac/consensus/scorer.h"
#include "diffsac/core/random.h"

namespace diffsac {

/// A model with its score.
template <MinimalModel Model>
struct ScoredModel {
  typename Model::Parameters model;
  double score;
};

/// Least squares on the points within `threshold` of *model; false, leaving *model, when they determine none.
template <MinimalModel Model>
bool FitInliers(const Scorer<Model>& scorer, double threshold, typename Model::Parameters* model) {
  const Eigen::VectorXd weights = (scorer.Residuals(*model).array() <= threshold).template cast<double>();
  typename Model::Parameters fitted;
  if (!Model::Fit(scorer.points(), weights, &fitted)) return false;
  *model = fitted;
  return true;
}

/// Inner sampling of locally optimised RANSAC (Chum, Matas, Kittler, DAGM 2003): `samples` times, least squares on
/// min(7γ, |I|/2) (at least γ) of the start's inliers I, then four rounds of least squares on the points within 2, 5/3,
/// 4/3 and 1 times `threshold`. Returns the best model met, the start itself when none scores higher; every fit is
/// added to *fits.
template <MinimalModel Model>
ScoredModel<Model> OptimizeLocally(const Scorer<Model>& scorer, const Score& score, double threshold, int samples,
                                   const ScoredModel<Model>& start, Rng rng, int* fits) {
  constexpr int kRounds = 4;
  constexpr double kWidest = 2.0;
  ScoredModel<Model> best = start;
  const auto offer = [&](const typename Model::Parameters& model, const Eigen::VectorXd& residuals) {
    const double value = scorer(model, residuals, score);
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
    typename Model::Parameters model;
    ++*fits;
    if (!Model::Fit(scorer.points(), weights, &model)) continue;
    scorer.Residuals(model, 0, scorer.size(), residuals.data());
    offer(model, residuals);
    for (int round = 0; round < kRounds; ++round) {
      const double factor = kWidest + (1.0 - kWidest) * round / (kRounds - 1);
      weights = (residuals.array() <= factor * threshold).template cast<double>();
      ++*fits;
      if (!Model::Fit(scorer.points(), weights, &model)) break;
      scorer.Residuals(model, 0, scorer.size(), residuals.data());
      offer(model, residuals);
    }
  }
  return best;
}

}  // namespace diffsac
