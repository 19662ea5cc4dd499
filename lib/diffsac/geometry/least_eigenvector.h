#pragma once

#include <Eigen/Core>

namespace diffsac {

/// The eigenvector of the least eigenvalue of a positive semidefinite 9 x 9 matrix. False when it is not unique: when
/// the two least eigenvalues are both rounding next to the largest, or when something is not finite.
bool LeastEigenvector(const Eigen::Matrix<double, 9, 9>& matrix, Eigen::Matrix<double, 9, 1>* vector);

}  // namespace diffsac
