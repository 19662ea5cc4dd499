#pragma once

#include "diffsac/eval/metrics.h"

namespace diffsac {

/// The worst errors of a pose, which a failure counts as.
inline constexpr double kWorstRotationDeg = 180.0;
inline constexpr double kWorstTranslationDeg = 90.0;

/// MeasureError for two views.
/// F and E: the pose that E (K2ᵀ F K1) and the estimate's inliers choose by cheirality, against the true one. Both errors
/// as in the CVPR 2020 RANSAC tutorial: the translation's sign does not count, a pose that cannot be chosen (fewer than 5
/// inliers, none before both cameras) is a failure of 180° and 90°. Where the true translation is zero its error is 0.
/// Without a true pose or without calibration: error_px, the mean Sampson distance of the true inliers, where they are
/// known (of labels, say); else all is NaN.
/// H: error_px against the true homography; NaN without one.
EstimateError MeasureTwoViewError(const Estimate& estimate, const Example& example);

}  // namespace diffsac
