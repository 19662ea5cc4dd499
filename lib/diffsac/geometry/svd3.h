#pragma once

#include <Eigen/Core>

namespace diffsac {

/// Singular value decomposition U diag(values) Vᵀ, values descending.
struct Svd3 {
  Eigen::Matrix3d u, v;
  Eigen::Vector3d values;
};

/// All NaN for a matrix that is not finite.
Svd3 ComputeSvd3(const Eigen::Matrix3d& matrix);

/// The same with the third columns of U and V turned so that both are rotations. Where the third value is zero, as for
/// fundamental and essential matrices, this is the same matrix.
Svd3 ComputeRotationSvd3(const Eigen::Matrix3d& matrix);

}  // namespace diffsac
