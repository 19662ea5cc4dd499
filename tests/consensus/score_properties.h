#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>

namespace diffsac::testing {

/// A function of one residual that claims to be a score.
struct ScoreFunction {
  std::function<double(double)> value;
  std::function<double(double)> derivative;
  double threshold;           ///< The scale of residuals worth looking at.
  std::vector<double> kinks;  ///< Where the derivative need not exist.
  double value_error = 0.0;   ///< How far `value` may be from the function `derivative` belongs to.
};

/// What every score must be: within [0, 1], 1 at 0, never rising, 0 far away and for NaN, with the derivative it says.
inline void CheckScore(const ScoreFunction& score) {
  constexpr int kSteps = 4000;
  CHECK(score.value(0.0) == Approx(1.0).epsilon(1e-12));
  double previous = 1.0 + 1e-12;
  for (int i = 0; i <= kSteps; ++i) {
    const double residual = 3.0 * score.threshold * i / kSteps;
    const double value = score.value(residual);
    REQUIRE(value >= 0.0);
    REQUIRE(value <= previous);
    previous = value;
  }
  CHECK(score.value(1e200) == 0.0);
  CHECK(score.value(std::numeric_limits<double>::infinity()) == 0.0);
  CHECK(score.value(std::numeric_limits<double>::quiet_NaN()) == 0.0);

  const double step = 1e-3 * score.threshold;
  for (int i = 1; i < 100; ++i) {
    const double residual = score.threshold * (0.01 + 0.02 * i);
    bool near_kink = false;
    for (double kink : score.kinks) near_kink |= std::abs(residual - kink) <= 2.0 * step;
    if (near_kink) continue;
    // Fourth order, so that the difference is exact enough for a step that drowns the table's error.
    const double slope = (8.0 * (score.value(residual + step) - score.value(residual - step)) -
                          (score.value(residual + 2.0 * step) - score.value(residual - 2.0 * step))) /
                         (12.0 * step);
    CAPTURE(residual);
    REQUIRE(score.derivative(residual) <= 0.0);
    REQUIRE(slope ==
            Approx(score.derivative(residual)).margin((1e-5 + 2.0 * score.value_error / 1e-3) / score.threshold));
  }
}

}  // namespace diffsac::testing
