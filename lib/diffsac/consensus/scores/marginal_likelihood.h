#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "diffsac/consensus/scores/score.h"

namespace diffsac {

/// The marginal likelihood of a model (Pritts and others, "RANSAC Scoring Done Right", arXiv 2606.27385, section 3),
/// against that of outliers alone.
///
/// An inlier's residual, of d dimensions, is Gaussian with σ, an outlier's uniform within ±a in each. σ is unknown:
/// σ² ~ InvGamma(n₀d/2, n₀dσ₀²/2), as if n₀ inliers of σ₀ had been seen before, is integrated out in closed form;
/// n₀ = 0 is the prior of Jeffreys, 1/σ². With n inliers whose squares sum up to RSS, the model itself taking γ of
/// them,
///   ν = (n − γ)d,   S(n) = log Γ(ν/2) − (ν/2) log(π RSS) + nd log 2a                                       (n₀ = 0)
///                   S(n) = log Γ(α + ν/2) − log Γ(α) + α log β − (α + ν/2) log(β + RSS/2) − (ν/2) log 2π + nd log 2a
/// with lengths in units of a, so that the score does not change with the unit, and of none it is 0. The inliers are
/// chosen for the greatest S, which is max(0, max over n > γ of S of the n smallest residuals). In nats: it is not
/// bounded by the number of points.
///
/// A point of weight w counts as w points, in n and in RSS.
///
/// Instead of sorting, residuals are counted by size (SquareHistogram). S is convex in n while points of one size
/// are added (ψ₁(z) ≥ 1/z), so that within a bin it is below its values at the ends of the bin with all points of the
/// bin at its lower edge. Only bins whose bound is above the best value at the edges are sorted.
class MarginalLikelihood : public ScoreFunction {
 public:
  explicit MarginalLikelihood(const ScoreSetting& setting)
      : MarginalLikelihood(setting.likelihood.half_width, setting.likelihood.dimension, setting.likelihood.free,
                           setting.likelihood.noise_prior, setting.sigma) {}
  /// half_width: a, linear, positive. dimension: d. free: γ. prior: n₀, and sigma: σ₀, linear.
  MarginalLikelihood(double half_width, int dimension, int free, double prior, double sigma);

  bool IsSum() const override { return false; }
  bool HasBound() const override { return true; }
  /// A residual that is not a number is as if infinitely far.
  double OfAll(const double* residuals, const double* weights, int count, double bar) const override;
  double BoundOfAll(const SquareHistogram& histogram) const override;
  /// a
  double unit() const override { return half_width_; }

 private:
  using Bin = SquareHistogram::Bin;
  using Values = Eigen::Array<double, Eigen::Dynamic, 1, 0, SquareHistogram::kBins, 1>;
  /// The bins that hold something and may hold the last inlier, what lies before them and at most S inside.
  struct Sweep {
    int size = 0;
    std::array<int, SquareHistogram::kBins> bins;
    std::array<Bin, SquareHistogram::kBins> before;
    Values bounds;
  };

  double Value(double weight, double squares) const;
  void SweepBins(const SquareHistogram& histogram, Sweep* sweep) const;
  double BestInside(const SquareHistogram& histogram, const Sweep& sweep, const std::vector<double>& squares,
                    const double* weights) const;

  double half_width_, inverse_half_width_;
  double half_dimension_;
  double free_;
  double shape_;     ///< α
  double scale_;     ///< β, in squares of a
  double constant_;  ///< α log β − log Γ(α)
};

}  // namespace diffsac
