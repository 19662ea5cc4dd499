#pragma once

#include <algorithm>

#include "diffsac/geometry/lanes.h"
#include "diffsac/geometry/square_bounds.h"
#include "diffsac/geometry/vector_clones.h"
#include "diffsac/ransac/scores/score.h"

namespace diffsac {

DIFFSAC_VECTOR_CLONES
static double SumMsac(const double* residuals, const double* weights, int count, double inverse_square) {
  return SumInLanes(
      residuals, weights, count, [=](double residual) { return 1.0 - residual * residual * inverse_square; },
      [](double share) { return share > 0.0 ? share : 0.0; });
}

/// Σ max(0, 1 − r²/ε²) (Torr and Zisserman, MLESAC, CVIU 2000).
class Msac : public ScoreFunction {
 public:
  explicit Msac(const ScoreSetting& setting)
      : threshold_(setting.threshold), inverse_square_(1.0 / (setting.threshold * setting.threshold)) {}
  double operator()(double residual) const override {
    return std::max(0.0, 1.0 - residual * residual * inverse_square_);
  }
  double Derivative(double residual) const override {
    return residual < threshold_ ? -2.0 * residual * inverse_square_ : 0.0;
  }
  double Sum(const double* residuals, const double* weights, int count) const override {
    return SumMsac(residuals, weights, count, inverse_square_);
  }
  bool HasUpperBound() const override { return true; }
  double UpperBound(const float* squares, const float* weights, int count) const override {
    return MsacBound(squares, weights, count);
  }
  double unit() const override { return threshold_; }

 private:
  double threshold_, inverse_square_;
};

}  // namespace diffsac
