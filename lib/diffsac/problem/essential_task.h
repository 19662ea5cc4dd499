#pragma once

#include "diffsac/geometry/covariance.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/epipolar_task.h"

namespace diffsac {

template <>
inline constexpr const char* kModelName<Essential> = "essential";

/// Two calibrated views, solved in normalised coordinates, K⁻¹ times pixels.
struct EssentialTask : EpipolarTask<EssentialTask, Essential> {
  /// A calibration, whose matrices are finite and can be inverted, of positive focal length.
  static bool Accepts(const Problem& problem);
  static PointMatrix Normalize(const Problem& problem, double* unit) {
    *unit = problem.cameras->MeanFocal();
    return NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2);
  }
  static PointMatrix FeatureCoordinates(const NormalizedProblem& space) {
    return space.is_normalized() ? space.points() : MatchCoordinates(space.problem());
  }
  static Eigen::Matrix3d EssentialOf(const Eigen::Matrix3d& model, const CameraPair&) { return model; }
  static ParallaxTest Parallax(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                               const NormalizedProblem& space) {
    return TestTurn(space.points(), model, inliers);
  }
  static std::optional<Eigen::MatrixXd> PoseCovariance(const ModelParameters&, const RigidMotion& pose,
                                                       const NormalizedProblem& space, const FitConditions& fit) {
    return RelativePoseCovariance(space.points(), {pose.rotation, pose.translation}, fit);
  }
  static double LeaveOutBehind(const ModelParameters&, const RigidMotion& pose, const NormalizedProblem& space,
                               double threshold, std::vector<std::uint8_t>* inliers) {
    return diffsac::LeaveOutBehind(pose, space.points(), threshold, inliers);
  }
  static Matrix3Parameters PixelModel(const ModelParameters& model, const Problem& problem) {
    if (!problem.cameras) return model;
    return AsParameters(FundamentalFromEssential(ModelMatrix(model), problem.cameras->K1, problem.cameras->K2));
  }
};

}  // namespace diffsac
