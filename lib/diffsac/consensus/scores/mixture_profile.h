#pragma once

#include <Eigen/Core>

#include "diffsac/consensus/scores/square_histogram.h"

namespace diffsac {

/// The likelihood of a mixture of Gaussian inliers and uniform outliers of which nothing is known, against that of
/// outliers alone: max over the share of inliers w and σ within [least, greatest] of
///   Σ log(1 − w + w ρ exp(−r²/2σ²)),   ρ = (extent / √(2π)σ)^d,
/// by expectation maximisation (MLESAC: Torr and Zisserman, CVIU 2000, with σ estimated as well), from the best of a
/// few σ. In nats; 0 without inliers, and never below. A point of weight w counts as w points.
///
/// Residuals are counted by size (square_histogram.h) and those of a bin taken to be their mean square, which changes
/// the score by less than a thousandth.
class MixtureProfile {
 public:
  /// least, greatest: σ's limits; extent: over which an outlier's residual is spread; linear, positive. dimension: d.
  MixtureProfile(double least, double greatest, double extent, int dimension);

  /// Beyond it an inlier has no density worth naming: 8 times the greatest σ. Squares are counted in its square.
  double reach() const { return reach_; }
  /// Of residuals (linear; not a number: as if infinitely far), with weights unless null. Gives up once it is known to
  /// be below `bar`, returning `bar`.
  double operator()(const double* residuals, const double* weights, int count, double bar) const;
  /// At least the score of residuals whose squares, in squares of reach(), are at least the counted ones: each point
  /// as near as its bin is, with the σ that suits it best, and all of them inliers.
  double Bound(const SquareHistogram& histogram) const;

 private:
  using Values = Eigen::Array<double, Eigen::Dynamic, 1, 0, SquareHistogram::kBins, 1>;
  /// The bins that hold something.
  struct Counts {
    Values weights, squares;  ///< Σ w and the mean square of each.
    double total;             ///< Σ w, of what is out of reach too.
  };
  struct Place {
    double share, variance, value;
  };

  /// ρ exp(−r²/2σ²) of each bin.
  Values Ratios(const Counts& counts, double variance) const;
  double Value(const Counts& counts, const Values& ratios, double share) const;
  Place Start(const Counts& counts) const;
  double Maximise(const Counts& counts) const;

  double least_, greatest_;  ///< Of σ², in squares of reach().
  double extent_square_;     ///< In squares of reach(), times 1/2π.
  double half_dimension_;
  double reach_;
  Eigen::Array<double, SquareHistogram::kBins, 1> most_;  ///< The greatest term of a point in each bin.
};

}  // namespace diffsac
