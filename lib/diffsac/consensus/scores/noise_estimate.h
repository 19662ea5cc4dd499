#pragma once

#include <Eigen/Core>

namespace diffsac {

/// Between which thresholds one that suits the noise is looked for; linear, in the unit of the residuals.
struct ThresholdRange {
  double least = 0.0;
  double greatest = 0.0;
  double extent = 0.0;  ///< The length over which an outlier's residual is spread: Mixture::Extent.
};

/// An inlier is within so many σ of the noise: 98.8 % of Gaussian residuals.
inline constexpr double kSigmasOfInlier = 2.5;

/// Finds the threshold that suits a model's residuals, when neither the noise nor the share of inliers is known: for
/// the mixture of Gaussian inliers and uniform outliers (mixture.h), the σ for which they are likeliest, each with the
/// share of inliers that suits it best; the threshold is kSigmasOfInlier·σ.
///
/// Thresholds are tried from the greatest down to the least in steps of half an octave, and a parabola says what is
/// between the best and its neighbours. Residuals are counted by their size first, four counts an octave, so that the
/// cost is one pass over the points and a fixed one for the counts. As many of the smallest residuals as a minimal set
/// has points are left out: the model takes them, whatever the noise.
class NoiseEstimator {
 public:
  /// free: γ. Where range.least is not below range.greatest, that is the answer.
  NoiseEstimator(const ThresholdRange& range, int free);
  /// The greatest threshold where no residual is left within it.
  double Threshold(const double* residuals, int count) const;

 private:
  /// Squares of residuals that share exponent and first mantissa bit are counted together; so many octaves of squares.
  static constexpr int kOctaves = 16;
  static constexpr int kBins = 2 * kOctaves;
  static constexpr int kMaxThresholds = 13;
  using Counts = Eigen::Array<double, kBins, 1>;

  Counts Count(const double* residuals, int count) const;
  double LogLikelihood(const Counts& counts, double total, int step) const;

  ThresholdRange range_;
  int free_;
  int steps_;
  Counts ratios_[kMaxThresholds];  ///< Of the density of inliers to that of outliers, by size, for each threshold.
};

}  // namespace diffsac
