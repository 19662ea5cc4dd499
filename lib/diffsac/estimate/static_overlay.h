#pragma once

#include <vector>

#include "diffsac/estimate/robust_estimator.h"

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

/// Whether half as many again of these rows agree with their own estimate, `moving`, as with that of all rows.
bool IsBetterMoving(const std::vector<int>& rows, const Estimate& moving, const Estimate& whole);

/// Makes an estimate of some of `count` rows one of all of them.
void SpreadMoving(const std::vector<int>& rows, std::size_t count, Estimate* moving);

}  // namespace diffsac
