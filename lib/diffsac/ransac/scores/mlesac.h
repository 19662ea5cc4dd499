#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "diffsac/ransac/scores/score.h"

namespace diffsac {

/// Σ of the log-likelihood ratio log(1 + k·exp(−r²/2σ²)) / log(1 + k): an inlier is Gaussian with σ, an outlier
/// uniform; k is the odds of the two densities at r = 0.
class Mlesac : public ScoreFunction {
 public:
  explicit Mlesac(const ScoreSetting& setting)
      : threshold_(setting.threshold),
        half_inverse_variance_(0.5 / (setting.sigma * setting.sigma)),
        odds_(setting.odds),
        inverse_log_(1.0 / std::log1p(setting.odds)) {}
  double operator()(double residual) const override {
    const double ratio = Ratio(residual);
    return ratio > 0.0 ? std::log1p(ratio) * inverse_log_ : 0.0;
  }
  double Derivative(double residual) const override {
    const double ratio = Ratio(residual);
    return ratio > 0.0 ? -2.0 * residual * half_inverse_variance_ * ratio / (1.0 + ratio) * inverse_log_ : 0.0;
  }
  double Sum(const double* residuals, const double* weights, int count) const override {
    if (weights != nullptr) return ScoreFunction::Sum(residuals, weights, count);
    // exp(-45) is 3e-20: points farther away add nothing that a double could hold, and most points are farther away.
    constexpr double kFar = 45.0;
    constexpr int kChunk = 64;
    double exponents[kChunk];
    double sum = 0.0;
    for (int begin = 0; begin < count; begin += kChunk) {
      int near = 0;
      for (int i = begin; i < std::min(begin + kChunk, count); ++i) {
        exponents[near] = residuals[i] * residuals[i] * half_inverse_variance_;
        near += exponents[near] < kFar ? 1 : 0;
      }
      const Eigen::Map<const Eigen::ArrayXd> x(exponents, near);
      sum += (1.0 + odds_ * (-x).exp()).log().sum();
    }
    return sum * inverse_log_;
  }
  double unit() const override { return threshold_; }

 private:
  double Ratio(double residual) const { return odds_ * std::exp(-residual * residual * half_inverse_variance_); }

  double threshold_, half_inverse_variance_, odds_, inverse_log_;
};

}  // namespace diffsac
