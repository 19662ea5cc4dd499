#pragma once

#include "diffsac/geometry/homography.h"
#include "diffsac/problem/chance_share.h"
#include "diffsac/problem/two_view_task.h"

namespace diffsac {

/// The mean distance |H x − H_true x| over JointlyVisiblePixels; over a 10 × 10 grid on the box of the matches in image
/// 1 where the images' sizes are unknown or nothing is visible in both; NaN without a true homography. Where the pose
/// and the calibration are known also the least error among the motions into which H decomposes.
EstimateError HomographyError(const ModelParameters* model, const std::vector<std::uint8_t>& inliers,
                              const Example& example);

/// The step of the grid that stands for all pixels.
inline constexpr int kVisibleStep = 4;

/// The pixels of image 1 (every kVisibleStep-th in both directions, from kVisibleStep / 2 on) that the true homography
/// takes into image 2, in front of the plane's horizon: the part of the plane that both images show (the CVPR 2020
/// RANSAC tutorial's homography error, there over every pixel). Empty without both images' sizes or a true homography.
std::vector<Eigen::Vector2d> JointlyVisiblePixels(const Example& example);

template <>
inline constexpr const char* kModelName<Homography> = "homography";

/// A plane in two views.
struct HomographyTask : TwoViewTask<Homography> {
  static constexpr bool kErrorInPixels = true;
  static const std::optional<Eigen::Matrix3d>& TrueMatrix(const GroundTruth& truth) { return truth.homography; }
  static EstimateError Error(const ModelParameters* model, const std::vector<std::uint8_t>& inliers,
                             const Example& example) {
    return HomographyError(model, inliers, example);
  }
  static double ChanceShare(const Problem& problem, double threshold) {
    return DiscShare(ImageExtent(problem.size2, problem.points.rightCols(2)), threshold);
  }
  static LinearEquations Equations(const SolverSpace& space, const GroundTruth& truth) {
    return HomographyEquations(space.points(), truth);
  }
};

}  // namespace diffsac
