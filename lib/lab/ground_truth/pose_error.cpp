#include "lab/ground_truth/pose_error.h"

#include <algorithm>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

/// With its sign; a t of zero says that there is none, which is right or wrong.
double SignedDirectionError(const Eigen::Vector3d& estimate, const Eigen::Vector3d& truth) {
  const bool told = estimate.norm() > 0.0, there = truth.norm() > 0.0;
  if (told && there) return DirectionAngleDegrees(estimate, truth);
  return told == there ? 0.0 : kWorstPoseDeg;
}

}  // namespace

void AddPoseError(const std::optional<RigidMotion>& pose, const Example& example, EstimateError* error) {
  const Problem& problem = example.problem;
  if (!IsTwoView(problem.task) || !example.truth.pose) return;
  if (!problem.cameras && !FindsFocals(problem.task)) return;
  error->pose_rotation_deg = error->pose_translation_deg = kWorstPoseDeg;
  if (pose && pose->rotation.allFinite() && pose->translation.allFinite()) {
    error->pose_rotation_deg = RotationAngleDegrees(pose->rotation, example.truth.pose->rotation);
    error->pose_translation_deg = SignedDirectionError(pose->translation, example.truth.pose->translation);
  }
  error->pose_deg = std::max(error->pose_rotation_deg, error->pose_translation_deg);
}

}  // namespace diffsac
