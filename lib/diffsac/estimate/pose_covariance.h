#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "diffsac/geometry/robust_loss.h"
#include "diffsac/problem/normalized_problem.h"

namespace diffsac {

/// Estimate::pose_covariance of a refined model and its pose (PoseOfEstimate); nothing for tasks without one.
std::optional<Eigen::MatrixXd> PoseCovarianceOf(const NormalizedProblem& space, const ModelParameters& model,
                                                const RigidMotion& pose, const FitConditions& fit);

/// Takes inliers that lie behind a camera of the model's motion out of *inliers, and returns
/// Estimate::cheirality_failure_ratio; 0 for tasks without cameras. threshold: what an inlier is, in the unit of the
/// space.
double LeaveOutBehind(const NormalizedProblem& space, const ModelParameters& model, const RigidMotion& pose,
                      double threshold, std::vector<std::uint8_t>* inliers);

}  // namespace diffsac
