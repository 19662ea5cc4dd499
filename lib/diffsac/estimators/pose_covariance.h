#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "diffsac/geometry/fit_conditions.h"
#include "diffsac/problem/solver_space.h"

namespace diffsac {

/// Estimate::pose_covariance of a refined model; nothing for tasks without one.
std::optional<Eigen::MatrixXd> PoseCovarianceOf(const SolverSpace& space, const ModelParameters& model,
                                                const std::vector<std::uint8_t>& inliers, const FitConditions& fit);

}  // namespace diffsac
