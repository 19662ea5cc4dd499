#pragma once

#include <cstdint>

#include "diffsac/ransac/scores/score.h"

namespace diffsac {

/// Σ [r ≤ ε] (Fischler and Bolles, 1981). Counted exactly where all points weigh alike.
class InlierCount : public ScoreFunction {
 public:
  explicit InlierCount(const ScoreSetting& setting) : threshold_(setting.threshold) {}
  double operator()(double residual) const override { return residual <= threshold_ ? 1.0 : 0.0; }
  double Derivative(double) const override { return 0.0; }
  double Sum(const double* residuals, const double* weights, int count) const override {
    if (weights != nullptr) return ScoreFunction::Sum(residuals, weights, count);
    std::int64_t inliers = 0;
    for (int i = 0; i < count; ++i) inliers += residuals[i] <= threshold_ ? 1 : 0;
    return static_cast<double>(inliers);
  }
  double unit() const override { return threshold_; }

 private:
  double threshold_;
};

}  // namespace diffsac
