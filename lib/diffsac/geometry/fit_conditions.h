#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/robust_loss.h"

namespace diffsac {

/// How a refined model was fitted to its points; lengths are linear, in the residuals' unit.
struct FitConditions {
  RobustLoss loss;               ///< What the model is a minimum of.
  double threshold = 0.0;        ///< Residuals of inliers are within it.
  Eigen::VectorXd weights = {};  ///< N values, of the points in that minimum; empty: 1 each.
};

}  // namespace diffsac
