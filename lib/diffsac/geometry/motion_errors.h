#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/rotation.h"

namespace diffsac {

/// What turns errors of a motion y = s R x + t, (ω, t) or (ω, t, log s) by `size` with R = exp([ω]ₓ) R̂, into those of
/// the same motion of points x + origin: its t is t − s R origin, so that an error of R moves it by the lever
/// s R origin. Covariances C become J C Jᵀ.
inline Eigen::MatrixXd ErrorsFromOrigin(const Eigen::Vector3d& lever, Eigen::Index size) {
  Eigen::MatrixXd change = Eigen::MatrixXd::Identity(size, size);
  change.block<3, 3>(3, 0) = CrossMatrix(lever);
  if (size == 7) change.block<3, 1>(3, 6) = -lever;
  return change;
}

}  // namespace diffsac
