#include "diffsac/ransac/scores/mixture.h"

#include <algorithm>
#include <cmath>

#include "diffsac/geometry/point_spread.h"

namespace diffsac {
namespace {

constexpr double kSqrtTwoPi = 2.50662827463100050242;
constexpr int kShareRounds = 100;
constexpr double kShareTolerance = 1e-6;
/// The share of inliers stays this far from 0 and 1, where expectation maximisation would be stuck.
constexpr double kShareMargin = 1e-4;

/// At most so large that its odds are finite for every share.
double ClampDensityRatio(double ratio) { return std::clamp(ratio, 2.0, 1e300); }

/// The share of inliers of greatest likelihood, from `start`: expectation maximisation on it alone.
double EstimateShareFrom(const Eigen::ArrayXd& ratios, double start) {
  double share = ClampShare(start);
  for (int round = 0; round < kShareRounds; ++round) {
    const double next = ClampShare((share * ratios / ((1.0 - share) + share * ratios)).mean());
    const bool settled = std::abs(next - share) < kShareTolerance;
    share = next;
    if (settled) break;
  }
  return share;
}

}  // namespace

double ClampShare(double share) { return std::clamp(share, kShareMargin, 1.0 - kShareMargin); }

Eigen::ArrayXd DensityRatios(const Mixture& mixture, const Eigen::VectorXd& residuals) {
  const double rate = -0.5 / (mixture.sigma * mixture.sigma);
  // A residual that is not a number counts as an infinite one.
  return residuals.array().isNaN().select(0.0, mixture.density_ratio * (rate * residuals.array().square()).exp());
}

double Mixture::Odds(double inlier_share) const { return density_ratio * inlier_share / (1.0 - inlier_share); }

double Mixture::Extent() const { return density_ratio * kSqrtTwoPi * sigma; }

Mixture Mixture::WithSigma(double other) const { return {other, ClampDensityRatio(density_ratio * sigma / other)}; }

Mixture MakeMixture(const PointMatrix& points, double inlier_threshold, double sigma) {
  // Matches have coordinates of several images, whose axes mean something.
  const Eigen::VectorXd sides =
      points.cols() <= 3 ? SpreadOf(points).sides
                         : Eigen::VectorXd((points.colwise().maxCoeff() - points.colwise().minCoeff()).transpose());
  const double mean_side = std::exp(sides.cwiseMax(2.0 * inlier_threshold).array().log().mean());
  return {sigma, ClampDensityRatio(mean_side / (kSqrtTwoPi * sigma))};
}

double MixtureScore(const Mixture& mixture, const Eigen::VectorXd& residuals) {
  if (residuals.size() == 0) return 0.0;
  const Eigen::ArrayXd ratios = DensityRatios(mixture, residuals);
  // The likelihood is concave in w, so any start leads to its one maximum.
  const double share = EstimateShareFrom(ratios, (ratios > 1.0).cast<double>().mean());
  const double sum = ((1.0 - share) + share * ratios).log().sum();
  return std::clamp(sum / std::log(mixture.density_ratio), 0.0, static_cast<double>(residuals.size()));
}

}  // namespace diffsac
