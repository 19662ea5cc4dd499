#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace diffsac::testing {

/// A function of one residual that says how much it costs: a robust loss, or one minus a score.
struct LossFunction {
  std::function<double(double)> value;
  std::function<double(double)> derivative;
  double scale;               ///< The size of residuals worth looking at.
  std::vector<double> kinks;  ///< Where the derivative need not exist.
  /// What the loss never exceeds, and is of a residual that is far away or no number; infinite for unbounded losses.
  double bound = std::numeric_limits<double>::infinity();
  double value_error = 0.0;  ///< How far `value` may be from the function `derivative` belongs to.
};

/// What every loss must be: 0 at 0, never falling, within its bound and at the bound far away and for NaN, with the
/// derivative it says.
inline void CheckLossFunction(const LossFunction& loss) {
  constexpr int kSteps = 4000;
  const double unit = std::isfinite(loss.bound) ? loss.bound : loss.value(loss.scale);
  CHECK(loss.value(0.0) == Approx(0.0).margin(1e-12 * unit));
  double previous = -1e-12 * unit;
  for (int i = 0; i <= kSteps; ++i) {
    const double residual = 3.0 * loss.scale * i / kSteps;
    const double value = loss.value(residual);
    REQUIRE(value >= previous);
    REQUIRE(value <= loss.bound);
    previous = value;
  }
  if (std::isfinite(loss.bound)) {
    CHECK(loss.value(1e100 * loss.scale) == loss.bound);
    CHECK(loss.value(std::numeric_limits<double>::infinity()) == loss.bound);
    CHECK(loss.value(std::numeric_limits<double>::quiet_NaN()) == loss.bound);
  } else {
    CHECK(loss.value(1e100 * loss.scale) > loss.value(1e50 * loss.scale));
    CHECK_FALSE(loss.value(std::numeric_limits<double>::quiet_NaN()) < previous);
  }

  const double step = 1e-3 * loss.scale;
  const double margin = (1e-5 * unit + 2.0 * loss.value_error / 1e-3) / loss.scale;
  for (int i = 1; i < 100; ++i) {
    const double residual = loss.scale * (0.01 + 0.02 * i);
    bool near_kink = false;
    for (double kink : loss.kinks) near_kink |= std::abs(residual - kink) <= 2.0 * step;
    if (near_kink) continue;
    // Fourth order, so that the difference is exact enough for a step that drowns the error of a tabulated value.
    const double slope = (8.0 * (loss.value(residual + step) - loss.value(residual - step)) -
                          (loss.value(residual + 2.0 * step) - loss.value(residual - 2.0 * step))) /
                         (12.0 * step);
    CAPTURE(residual);
    REQUIRE(loss.derivative(residual) >= 0.0);
    REQUIRE(slope == Approx(loss.derivative(residual)).margin(margin));
  }
}

}  // namespace diffsac::testing
