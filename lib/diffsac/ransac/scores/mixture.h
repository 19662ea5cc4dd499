#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/ransac/scores/scorer.h"

namespace diffsac {

/// The Gaussian-uniform mixture of distances to a model (as in MLESAC: Torr and Zisserman, CVIU 2000).
///
/// An inlier is Gaussian across the model and uniform along it, an outlier uniform in a box of the points, of volume V.
/// With the model's extent inside the box taken as V^((D−1)/D), the ratio of the two densities at distance r is
/// ρ·exp(−r²/2σ²) with ρ = V^(1/D) / (√(2π) σ).
struct Mixture {
  double sigma = 0.0;          ///< σ, in the data's unit.
  double density_ratio = 2.0;  ///< ρ, at least 2.
  /// ρ·w/(1 − w): the odds of an inlier at r = 0 when the share of inliers is w.
  double Odds(double inlier_share) const;
  /// V^(1/D), the length over which an outlier's residual is spread.
  double Extent() const;
  /// The same mixture with another σ; ρ follows.
  Mixture WithSigma(double other) const;
};

/// The box is that of points in the plane or in space by their covariance (SpreadOf), which no turn changes, and the
/// bounding box of others. Each side counts as at least 2ε, so that points on one model keep a volume.
Mixture MakeMixture(const PointMatrix& points, double inlier_threshold, double sigma);

/// ρ exp(−r²/2σ²) of each point, 0 where r is not a number.
Eigen::ArrayXd DensityRatios(const Mixture& mixture, const Eigen::VectorXd& residuals);

/// The share kept away from 0 and 1, where expectation maximisation would be stuck.
double ClampShare(double share);

/// Σ log(1 − w + w ρ exp(−r²/2σ²)) / log ρ with the best w: the log-likelihood ratio of the mixture against "all
/// outliers", in [0, N].
double MixtureScore(const Mixture& mixture, const Eigen::VectorXd& residuals);

/// As `sigma_prior` of MixtureRefit: σ is known and stays.
inline constexpr double kSigmaKnown = std::numeric_limits<double>::infinity();

/// Expectation maximisation over the model, w and, unless it is known, σ, from *model and the inlier share `start`.
/// Each iteration weights every point by its posterior probability q of being an inlier and fits by weighted total
/// least squares; stops when no weight moves by more than 1e-3, after 30 iterations (100 with σ), or when the fit fails
/// (the last model stays). sigma_prior: how many inliers' worth of evidence mixture.sigma (σ₀) counts as; the estimate
/// is σ² = (Σ q r² + sigma_prior·σ₀²) / (max(0, Σ q − γ) + sigma_prior), the γ observations that the model itself takes
/// being left out. Must be positive.
/// Returns the number of fits; *model is the result, *sigma (unless null) the σ that goes with it.
template <MinimalModel Model>
int MixtureRefit(const PointMatrix& points, const Mixture& mixture, double start, typename Model::Parameters* model,
                 double sigma_prior = kSigmaKnown, double* sigma = nullptr) {
  // σ and the weights follow each other, which takes longer to settle.
  constexpr int kRounds = 30, kRoundsWithSigma = 100;
  constexpr double kWeightTolerance = 1e-3;
  const Scorer<Model> scorer(points);
  const bool sigma_known = std::isinf(sigma_prior);
  const auto estimated_sigma = [&](const Eigen::VectorXd& weights) {
    const double squares =
        weights.dot(scorer.Residuals(*model).cwiseAbs2()) + sigma_prior * mixture.sigma * mixture.sigma;
    return std::sqrt(squares / (std::max(0.0, weights.sum() - Model::kMinimalSize) + sigma_prior));
  };
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(points.rows());
  Mixture current = mixture;
  double share = ClampShare(start);
  int fits = 0;
  while (fits < (sigma_known ? kRounds : kRoundsWithSigma)) {
    const Eigen::ArrayXd ratios = share * DensityRatios(current, scorer.Residuals(*model));
    const Eigen::VectorXd next = ratios / ((1.0 - share) + ratios);
    if (fits > 0 && (next - weights).cwiseAbs().maxCoeff() <= kWeightTolerance) break;
    weights = next;
    share = ClampShare(weights.mean());
    ++fits;
    if (!FitAgain<Model>(points, weights, model)) break;
    if (!sigma_known) current = mixture.WithSigma(estimated_sigma(weights));
  }
  if (sigma != nullptr) *sigma = current.sigma;
  return fits;
}

}  // namespace diffsac
