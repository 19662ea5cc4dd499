#pragma once

#include <Eigen/Core>
#include <vector>

#include "diffsac/eval/metrics.h"

namespace diffsac {

/// The worst errors of a pose, which a failure counts as.
inline constexpr double kWorstRotationDeg = 180.0;
inline constexpr double kWorstTranslationDeg = 90.0;

/// MeasureError for two views.
/// F and E: the pose that E (K2ᵀ F K1) and the estimate's inliers choose by cheirality, against the true one. Both
/// errors as in the CVPR 2020 RANSAC tutorial: the translation's sign does not count, a pose that cannot be chosen
/// (fewer than 5 inliers, none before both cameras) is a failure of 180° and 90°. Where the true translation is zero
/// its error is 0. Without a true pose or without calibration: error_px, the mean Sampson distance of the true inliers,
/// where they are known (of labels, say); else all is NaN. H: error_px, the mean distance |H x − H_true x| over
/// JointlyVisiblePixels; over a 10 × 10 grid on the box of the matches in image 1 where the images' sizes are unknown
/// or nothing is visible in both. NaN without a true homography.
EstimateError MeasureTwoViewError(const Estimate& estimate, const Example& example);

/// The step of the grid that stands for all pixels.
inline constexpr int kVisibleStep = 4;

/// The pixels of image 1 (every kVisibleStep-th in both directions, from kVisibleStep / 2 on) that the true homography
/// takes into image 2, in front of the plane's horizon: the part of the plane that both images show (the CVPR 2020
/// RANSAC tutorial's homography error, there over every pixel). Empty without both images' sizes or a true homography.
std::vector<Eigen::Vector2d> JointlyVisiblePixels(const Example& example);

}  // namespace diffsac
