#pragma once

#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/shared_focal_task.h"

namespace diffsac {

template <>
inline constexpr const char* kModelName<Fundamental> = "fundamental";
template <>
inline constexpr const char* kModelName<Fundamental8> = "fundamental8";

/// Two uncalibrated views; the calibration, where it is known, is the metric's alone. Sets of 7 points, or of 8.
struct FundamentalTask : EpipolarTask<FundamentalTask, Fundamental, Fundamental8> {
  static Eigen::Matrix3d EssentialOf(const Eigen::Matrix3d& model, const CameraPair& cameras) {
    return EssentialFromFundamental(model, cameras.K1, cameras.K2);
  }
  /// Of a camera behind both images (PutCameraBehind).
  static FocalEstimate InPixels(const FocalPosteriors& posteriors, const Problem& problem) {
    return FocalInPixels(UnknownFocal::kBoth, posteriors, problem);
  }
  /// Only the calibration tells a pure rotation from a plane.
  static ParallaxTest Parallax(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                               const NormalizedProblem& space) {
    const Problem& problem = space.problem();
    ParallaxTest test;
    if (problem.cameras)
      test = TestTurn(NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2),
                      AsParameters(EssentialOf(ModelMatrix(model), *problem.cameras)), inliers);
    return IsUndetermined(test.degeneracy) ? test : TestPlane(problem.points, model, inliers);
  }
};

}  // namespace diffsac
