#pragma once

#include "diffsac/consensus/local/local_optimization.h"
#include "diffsac/consensus/scores/magsac.h"

namespace diffsac {

/// Iteratively reweighted least squares with the weights of MAGSAC++ (σ-consensus++: Barath, Noskova, Ivashechkin,
/// Matas, CVPR 2020, section 3.2), until no weight moves by more than 1e-3 of the largest, `rounds` times at most.
/// Returns the best model met by `score`, the start itself when none scores higher; every fit is added to *fits.
template <MinimalModel Model>
ScoredModel<Model> OptimizeReweighted(const Scorer<Model>& scorer, const Score& score, const MagsacLoss& loss,
                                      int rounds, const ScoredModel<Model>& start, int* fits) {
  constexpr double kTolerance = 1e-3;
  ScoredModel<Model> best = start;
  typename Model::Parameters model = start.model;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(scorer.size());
  for (int round = 0; round < rounds; ++round) {
    Eigen::VectorXd next = scorer.Residuals(model).unaryExpr([&](double r) { return loss.Weight(r); });
    const double largest = next.maxCoeff();
    if (!(largest > 0.0)) break;
    next /= largest;
    if (round > 0 && (next - weights).cwiseAbs().maxCoeff() <= kTolerance) break;
    weights = next;
    ++*fits;
    if (!FitAgain(scorer, weights, &model)) break;
    const double value = scorer(model, score, best.score);
    if (value > best.score) best = {model, value};
  }
  return best;
}

}  // namespace diffsac
