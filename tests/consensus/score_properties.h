#pragma once

#include <functional>
#include <vector>

#include "geometry/loss_properties.h"

namespace diffsac::testing {

/// A function of one residual that claims to be a score.
struct ScoreFunction {
  std::function<double(double)> value;
  std::function<double(double)> derivative;
  double threshold;           ///< The scale of residuals worth looking at.
  std::vector<double> kinks;  ///< Where the derivative need not exist.
  double value_error = 0.0;   ///< How far `value` may be from the function `derivative` belongs to.
};

/// What every score must be: one minus a loss bounded by 1. So within [0, 1], 1 at 0, never rising, 0 far away and for
/// NaN, with the derivative it says.
inline void CheckScore(const ScoreFunction& score) {
  CheckLossFunction({[&](double r) { return 1.0 - score.value(r); }, [&](double r) { return -score.derivative(r); },
                     score.threshold, score.kinks, 1.0, score.value_error});
}

}  // namespace diffsac::testing
