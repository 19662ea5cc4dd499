#pragma once

#include <limits>

#include "diffsac/estimators/robust_estimator.h"
#include "lab/truth/example.h"

namespace diffsac {

/// The share of χ² with so many degrees of freedom, 1 or more, that lies below a value of 0 or more.
double ChiSquareBelow(double value, int freedom);

/// Two views, how far an estimate is from the truth by its own covariance: the confidence, in [0, 1], of the smallest
/// region about R (t's direction) that holds the true one. A 68 % region holds the truth where it is .68 at most.
/// Covariances that say what is so give every confidence equally often.
struct PoseLevels {
  double rotation = std::numeric_limits<double>::quiet_NaN();
  double translation = std::numeric_limits<double>::quiet_NaN();  ///< NaN of cameras in one place.
};

/// NaN without a covariance or a true pose, and for other tasks than those of two views.
PoseLevels PoseLevelsOf(const Estimate& estimate, const Example& example);

}  // namespace diffsac
