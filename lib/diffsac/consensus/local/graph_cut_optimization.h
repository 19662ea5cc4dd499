#pragma once

#include <algorithm>
#include <vector>

#include "diffsac/consensus/local/graph_cut.h"
#include "diffsac/consensus/local/local_optimization.h"

namespace diffsac {

/// Local optimisation of graph-cut RANSAC (Barath and Matas, CVPR 2018, algorithm 2): the best model's inliers are
/// found by a graph cut, then least squares on all of them and, `samples` times, on 7γ random ones; from the start
/// again while the score rises, kRounds times at most. Returns the best model met, the start itself when none scores
/// higher; every fit is added to *fits.
template <MinimalModel Model>
ScoredModel<Model> OptimizeByGraphCut(const Scorer<Model>& scorer, const Score& score, double threshold,
                                      const GraphCut& graph_cut, int samples, const ScoredModel<Model>& start, Rng rng,
                                      int* fits) {
  constexpr int kRounds = 10;
  ScoredModel<Model> best = start;
  std::vector<int> inliers, chosen;
  const auto fit = [&](const Eigen::VectorXd& weights) {
    typename Model::Parameters model = best.model;
    ++*fits;
    if (!FitAgain(scorer, weights, &model)) return;
    const double value = scorer(model, score, best.score);
    if (value > best.score) best = {model, value};
  };
  for (int round = 0; round < kRounds; ++round) {
    const double before = best.score;
    const std::vector<std::uint8_t> labels = graph_cut.Label(scorer.Residuals(best.model), threshold);
    inliers.clear();
    for (int i = 0; i < scorer.size(); ++i)
      if (labels[i]) inliers.push_back(i);
    const int available = static_cast<int>(inliers.size());
    if (available < Model::kMinimalSize) break;
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(scorer.size());
    for (int i : inliers) weights[i] = 1.0;
    fit(weights);
    const int size = std::min(7 * Model::kMinimalSize, available);
    chosen.resize(size);
    for (int sample = 0; sample < samples && size < available; ++sample) {
      rng.Distinct(available, size, chosen.data());
      weights.setZero();
      for (int position : chosen) weights[inliers[position]] = 1.0;
      fit(weights);
    }
    if (!(best.score > before)) break;
  }
  return best;
}

}  // namespace diffsac
