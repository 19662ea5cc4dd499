#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace diffsac {

/// Steps of Levenberg-Marquardt that are tried where nobody asks for fewer.
inline constexpr int kMostRefineSteps = 25;

/// How a squared residual s counts, c being the loss's scale (linear, in the residual's unit):
///   kTrivial    ρ(s) = s
///   kTruncated  ρ(s) = min(s, c²)                       MSAC's; an outlier has no pull at all
///   kHuber      ρ(s) = s for s ≤ c², else 2 c √s − c²   (Huber, 1964)
///   kCauchy     ρ(s) = c² log(1 + s / c²)
///   kMarginalised  ρ(s) ∝ ∫ min(s/t², 1) dt/t², t from `least` to c: the truncated loss over all scales, each a share
///                  1/t of its octave. s for s ≤ least², then falling off in weight as √s⁻³; no pull beyond c.
enum class LossKind { kTrivial, kTruncated, kHuber, kCauchy, kMarginalised };

/// ρ with ρ(0) = 0, ρ'(0) = 1, never decreasing, and ρ(s) ≤ s.
struct RobustLoss {
  LossKind kind = LossKind::kTrivial;
  double scale = 1.0;
  double least = 0.0;  ///< Of kMarginalised, in (0, scale): the smallest scale.

  /// ρ(s). A residual that is not a number counts as an infinite one.
  double Value(double s) const {
    const double square = scale * scale;
    switch (kind) {
      case LossKind::kTruncated:
        return s < square ? s : square;
      case LossKind::kHuber:
        return s <= square ? s : 2.0 * scale * std::sqrt(s) - square;
      case LossKind::kCauchy:
        return square * std::log1p(s / square);
      case LossKind::kMarginalised:
        return ScalesValue(s < square ? s : square);
      case LossKind::kTrivial:
        break;
    }
    return s;
  }

  /// ρ'(s), the weight of the residual in iteratively reweighted least squares; 0 for one that is not finite.
  double Weight(double s) const {
    const double square = scale * scale;
    if (!std::isfinite(s)) return 0.0;
    switch (kind) {
      case LossKind::kTruncated:
        return s <= square ? 1.0 : 0.0;
      case LossKind::kHuber:
        return s <= square ? 1.0 : scale / std::sqrt(s);
      case LossKind::kCauchy:
        return square / (square + s);
      case LossKind::kMarginalised:
        return s < square ? Slope(scale / std::max(std::sqrt(s), least)) / Slope(scale / least) : 0.0;
      case LossKind::kTrivial:
        break;
    }
    return 1.0;
  }

 private:
  /// ∫ dt/t⁴ from c/inverse to c, in units of c: their cubes are ordinary numbers.
  static double Slope(double inverse) { return (inverse * inverse * inverse - 1.0) / 3.0; }

  double ScalesValue(double s) const {
    if (s <= least * least) return s;
    const double inverse = scale / std::sqrt(s), square = scale * scale;
    // Scales below the residual count in full, those above by s/t².
    return square * (scale / least - inverse + s / square * Slope(inverse)) / Slope(scale / least);
  }
};

/// How a refined model was fitted to its points; lengths are linear, in the residuals' unit.
struct FitConditions {
  RobustLoss loss;               ///< What the model is a minimum of.
  double threshold = 0.0;        ///< Residuals of inliers are within it.
  Eigen::VectorXd weights = {};  ///< N values, of the points in that minimum; empty: 1 each.
};

}  // namespace diffsac
