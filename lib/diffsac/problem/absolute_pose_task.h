#pragma once

#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/covariance.h"
#include "diffsac/problem/chance_share.h"
#include "diffsac/problem/task_description.h"

namespace diffsac {

template <>
inline constexpr const char* kModelName<AbsolutePose> = "absolute_pose";

/// The pose of one image in a known scene. Points are X Y Z u v: a point of the scene and its image in pixels, without
/// lens distortion; cameras->K1 is the calibration; the inlier threshold is in pixels. Solved in normalised
/// coordinates, K⁻¹ (u, v, 1).
struct AbsolutePoseTask : TaskDescriptionOf<AbsolutePose> {
  static bool Accepts(const Problem& problem);
  static PointMatrix Normalize(const Problem& problem, double* unit);
  /// The scene about its median by its spread, and the normalised image.
  static PointMatrix FeatureCoordinates(const NormalizedProblem& space);
  static std::optional<RigidMotion> Pose(const ModelParameters& model, const std::vector<std::uint8_t>&,
                                         const NormalizedProblem&) {
    return RigidMotion{RotationOf(model), TranslationOf(model)};
  }
  static std::optional<Eigen::MatrixXd> PoseCovariance(const ModelParameters& model, const RigidMotion&,
                                                       const NormalizedProblem& space, const FitConditions& fit) {
    return AbsolutePoseCovariance(space.points(), model, fit);
  }
  /// Points behind the camera are no inliers: only their share, or that of the points which fit a mirrored scene.
  static double LeaveOutBehind(const ModelParameters& model, const RigidMotion& pose, const NormalizedProblem& space,
                               double threshold, std::vector<std::uint8_t>* inliers);
  static PointMatrix ImagePoints(const Problem& problem) { return problem.points.rightCols(2); }
  static double ChanceShare(const Problem& problem, double threshold) {
    return DiscShare(ImageExtent(problem.size1, ImagePoints(problem)), threshold);
  }
};

}  // namespace diffsac
