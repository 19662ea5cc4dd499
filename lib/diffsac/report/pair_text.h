#pragma once

#include <string>

#include "diffsac/problem/problem.h"
#include "diffsac/estimators/robust_estimator.h"

namespace diffsac {

/// Milliseconds of what happens before an estimate.
struct PairTimes {
  double keypoints = 0.0, matching = 0.0;
  double first_call = 0.0;  ///< Of the first estimate, in which networks and allocators get ready; 0: not told.
};

/// What an estimate says of two images, for a terminal: matrix, pose where it has one, inliers, noise, milliseconds by
/// stage. Without an estimate, why.
std::string PairText(const Example& pair, const Estimate& estimate, const PairTimes& times);

/// The same as one JSON object, with the inliers' rows.
std::string PairJson(const Example& pair, const Estimate& estimate, const PairTimes& times);

}  // namespace diffsac
