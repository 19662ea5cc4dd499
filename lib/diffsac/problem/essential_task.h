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
  static PointMatrix FeatureCoordinates(const SolverSpace& space) {
    return space.is_normalized() ? space.points() : MatchCoordinates(space.problem());
  }
  static Eigen::Matrix3d EssentialOf(const Eigen::Matrix3d& model, const CameraPair&) { return model; }
  static ParallaxTest Parallax(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                               const Problem& problem) {
    return CalibratedParallax(ModelMatrix(model), *problem.cameras, inliers, problem.points);
  }
  static std::optional<Eigen::MatrixXd> PoseCovariance(const ModelParameters& model,
                                                       const std::vector<std::uint8_t>& inliers,
                                                       const SolverSpace& space, const FitConditions& fit) {
    const auto pose = Pose(model, inliers, space.problem());
    if (!pose) return std::nullopt;
    return RelativePoseCovariance(space.points(), {pose->rotation, pose->translation}, fit);
  }
  static double LeaveOutBehind(const ModelParameters& model, const SolverSpace& space, double threshold,
                               std::vector<std::uint8_t>* inliers) {
    return diffsac::LeaveOutBehind(Pose(model, *inliers, space.problem()), space.points(), threshold, inliers);
  }
  static Matrix3Parameters PixelModel(const ModelParameters& model, const Problem& problem) {
    if (!problem.cameras) return model;
    return AsParameters(FundamentalFromEssential(ModelMatrix(model), problem.cameras->K1, problem.cameras->K2));
  }
};

}  // namespace diffsac
