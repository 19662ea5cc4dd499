#pragma once

#include <vector>

#include "diffsac/estimators/robust_estimator.h"

namespace diffsac {

// What lies on the images and not in the scene (a watermark, dirt on the lens) stands still while the scene moves. Any
// translation without a turn explains it, so that it wins over a scene of fewer matches, or joins part of it.

/// The rows of matches that move, where most inliers of epipolar geometry stand still; none otherwise.
std::vector<int> RowsThatMove(const Problem& problem, const Estimate& estimate);

/// Puts the estimate of these rows alone in the place of *whole, where half as many again of them agree with it.
void PreferMoving(const std::vector<int>& rows, Estimate moving, Estimate* whole);

}  // namespace diffsac
