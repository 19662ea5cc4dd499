#pragma once

#include <vector>

#include "diffsac/estimators/robust_estimator.h"

namespace diffsac {

// What lies on the images and not in the scene (a watermark, dirt on the lens) stands still while the scene moves. Any
// translation without a turn explains it, so that it wins over a scene of fewer matches, or joins part of it.

/// Fewer matches that move prove nothing.
inline constexpr int kLeastMoving = 12;

/// A match stands still within so many thresholds of an inlier's distance from its line, which has one dimension less.
inline constexpr double kStillReach = 2.0;

/// The rows of matches of two images that lie farther apart than `reach`; none where the points are no such matches.
std::vector<int> RowsFartherThan(const Problem& problem, double reach);

/// The rows of matches that move, where most inliers of epipolar geometry stand still; none otherwise.
std::vector<int> RowsThatMove(const Problem& problem, const Estimate& estimate);

/// Puts the estimate of these rows alone in the place of *whole, where half as many again of them agree with it.
void PreferMoving(const std::vector<int>& rows, Estimate moving, Estimate* whole);

}  // namespace diffsac
