#pragma once

// The definitions behind mixture.h, for the files that instantiate them for a model.

#include <algorithm>
#include <cmath>

#include "diffsac/consensus/scores/mixture.h"
#include "diffsac/consensus/scores/scorer.h"

namespace diffsac {
namespace mixture_internal {

inline constexpr int kRefitRounds = 30;
/// σ and the weights follow each other, which takes longer to settle.
inline constexpr int kRefitRoundsWithSigma = 100;
inline constexpr double kWeightTolerance = 1e-3;

template <MinimalModel Model>
double EstimateSigma(const Eigen::VectorXd& residuals, const Eigen::VectorXd& weights, double sigma, double prior) {
  const double squares = weights.dot(residuals.cwiseAbs2()) + prior * sigma * sigma;
  return std::sqrt(squares / (std::max(0.0, weights.sum() - Model::kMinimalSize) + prior));
}

}  // namespace mixture_internal

template <MinimalModel Model>
int MixtureRefit(const PointMatrix& points, const Mixture& mixture, double start, typename Model::Parameters* model,
                 double sigma_prior, double* sigma) {
  using namespace mixture_internal;
  const Scorer<Model> scorer(points);
  const bool sigma_known = std::isinf(sigma_prior);
  const int rounds = sigma_known ? kRefitRounds : kRefitRoundsWithSigma;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(points.rows());
  Mixture current = mixture;
  double share = ClampShare(start);
  int fits = 0;
  while (fits < rounds) {
    const Eigen::ArrayXd ratios = share * DensityRatios(current, scorer.Residuals(*model));
    const Eigen::VectorXd next = ratios / ((1.0 - share) + ratios);
    if (fits > 0 && (next - weights).cwiseAbs().maxCoeff() <= kWeightTolerance) break;
    weights = next;
    share = ClampShare(weights.mean());
    ++fits;
    if (!FitAgain<Model>(points, weights, model)) break;
    if (!sigma_known)
      current = mixture.WithSigma(EstimateSigma<Model>(scorer.Residuals(*model), weights, mixture.sigma, sigma_prior));
  }
  if (sigma != nullptr) *sigma = current.sigma;
  return fits;
}

}  // namespace diffsac
