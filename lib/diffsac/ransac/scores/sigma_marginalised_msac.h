#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "diffsac/geometry/lanes.h"
#include "diffsac/geometry/square_bounds.h"
#include "diffsac/geometry/vector_clones.h"
#include "diffsac/ransac/scores/score.h"

namespace diffsac {

/// A residual's contribution as a function of its share of the greatest scale.
template <class Real>
struct OverScales {
  Real least, norm;

  /// NaN counts as the greatest scale, where the score is 0.
  static Real Near(Real share) { return share < Real(1) ? share : Real(1); }
  /// near: Near(share). In shares of the greatest scale: their cubes are ordinary numbers.
  Real operator()(Real near) const {
    const Real inverse = Real(1) / (near > least ? near : least);
    const Real slope = (inverse * inverse * inverse - Real(1)) / Real(3);
    return (inverse - Real(1) - near * near * slope) * norm;
  }
};

DIFFSAC_VECTOR_CLONES
static double SumOverScales(const double* residuals, const double* weights, int count, double inverse,
                            OverScales<double> scales) {
  return SumInLanes(
      residuals, weights, count, [=](double residual) { return OverScales<double>::Near(residual * inverse); }, scales);
}

/// 1/√x from above, by up to kRootSlack: without a root and a quotient, which all else would wait for.
inline constexpr float kRootSlack = 1.9e-3f;
inline float InverseRootFromAbove(float x) {
  const float guess = std::bit_cast<float>(0x5f375a86u - (std::bit_cast<std::uint32_t>(x) >> 1));
  // Newton's step ends below, by 1.76e-3 at most.
  return guess * (1.5f - 0.5f * x * guess * guess) * (1.0f + 1.8e-3f);
}

/// A term as a function of the inverse share v is v − 1 − near² (v³ − 1)/3, largest at v = 1/near, and rises with v up
/// to there; the slack of v is made up for in SigmaMarginalisedMsac::UpperBound.
DIFFSAC_BOUND_CLONES
static float BoundOverScales(const float* squares, const float* weights, int count, float most, float norm) {
  return SumFloats<kBoundBlock>(
      squares, weights, count, [](float square) { return square < 1.0f ? square : 1.0f; },
      [=](float square) {
        const float root = InverseRootFromAbove(square + 1e-12f);
        const float inverse = root < most ? root : most;
        return (inverse - 1.0f - square * ((inverse * inverse * inverse - 1.0f) * (1.0f / 3.0f))) * norm;
      });
}

/// Σ ∫ max(0, 1 − r²/t²) dt/t², t from the least to the greatest scale, divided by its value for r = 0: MSAC over all
/// scales, each a share 1/t of its octave. Needs no ε that suits the noise: between the two a point counts as 1/r,
/// whatever ε is.
class SigmaMarginalisedMsac : public ScoreFunction {
 public:
  explicit SigmaMarginalisedMsac(const ScoreSetting& setting)
      : greatest_(setting.greatest),
        inverse_(1.0 / setting.greatest),
        least_share_(std::clamp(setting.least / setting.greatest, kLeastShare, kLargestShare)),
        norm_(1.0 / (1.0 / least_share_ - 1.0)) {}
  double operator()(double residual) const override {
    return OverScales<double>{least_share_, norm_}(OverScales<double>::Near(residual * inverse_));
  }
  double Derivative(double residual) const override {
    const double share = residual * inverse_;
    if (!(share < 1.0)) return 0.0;
    const double inverse = 1.0 / std::max(share, least_share_);
    return -2.0 / 3.0 * share * (inverse * inverse * inverse - 1.0) * norm_ * inverse_;
  }
  double Sum(const double* residuals, const double* weights, int count) const override {
    return SumOverScales(residuals, weights, count, inverse_, {least_share_, norm_});
  }
  bool HasUpperBound() const override { return true; }
  double UpperBound(const float* squares, const float* weights, int count) const override {
    // A term is a difference of numbers up to `most`, times the norm; v's slack takes off its square.
    const double most = 1.0 / least_share_;
    const double slack = (16.0 * std::numeric_limits<float>::epsilon() + kRootSlack * kRootSlack) * norm_ * most;
    return static_cast<double>(
               BoundOverScales(squares, weights, count, static_cast<float>(most), static_cast<float>(norm_))) +
           slack * count;
  }
  double unit() const override { return greatest_; }

 private:
  /// The smallest scale as a share of the greatest. At the second all scales are one, and the score is MSAC.
  static constexpr double kLeastShare = 1e-3, kLargestShare = 0.99;

  double greatest_, inverse_, least_share_, norm_;
};

}  // namespace diffsac
