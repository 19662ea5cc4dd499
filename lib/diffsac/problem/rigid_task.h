#pragma once

#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/rigid.h"
#include "diffsac/problem/chance_share.h"
#include "diffsac/problem/task_description.h"

namespace diffsac {

template <>
inline constexpr const char* kModelName<Rigid> = "rigid";
template <>
inline constexpr const char* kModelName<Similarity> = "similarity";

/// The motion, and with a scale the similarity, between two clouds by matches x1 x2 x3 y1 y2 y3, in the clouds' units;
/// the inlier threshold is in the second cloud's.
template <bool kScaled>
struct CloudMotionTask : TaskDescriptionOf<CloudMotion<kScaled>> {
  static constexpr bool kTwoClouds = true;
  /// Each cloud about its median by its spread.
  static PointMatrix FeatureCoordinates(const NormalizedProblem& space);
  /// Without the scale.
  static std::optional<RigidMotion> Pose(const ModelParameters& model, const std::vector<std::uint8_t>&,
                                         const NormalizedProblem&);
  /// MotionCovariance.
  static std::optional<Eigen::MatrixXd> PoseCovariance(const ModelParameters& model, const RigidMotion&,
                                                       const NormalizedProblem& space, const FitConditions& fit) {
    return MotionCovariance<kScaled>(space.points(), model, fit);
  }
  static double ChanceShare(const Problem& problem, double threshold) {
    return OccupiedShare(problem.points.rightCols(3), threshold);
  }
};

using RigidTask = CloudMotionTask<false>;
using SimilarityTask = CloudMotionTask<true>;

extern template struct CloudMotionTask<false>;
extern template struct CloudMotionTask<true>;

}  // namespace diffsac
