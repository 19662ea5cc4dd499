#include "diffsac/geometry/least_eigenvector.h"

#include <Eigen/Eigenvalues>

namespace diffsac {
namespace {

/// Second least over largest eigenvalue (squares of singular values) below which the solution is not unique.
constexpr double kMinShare = 1e-14;

}  // namespace

bool LeastEigenvector(const Eigen::Matrix<double, 9, 9>& matrix, Eigen::Matrix<double, 9, 1>* vector) {
  const double trace = matrix.trace();
  if (!(trace > 0.0) || !matrix.allFinite()) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(matrix / trace);
  if (solver.info() != Eigen::Success) return false;
  const auto& values = solver.eigenvalues();
  if (!(values[1] > kMinShare * values[8])) return false;
  *vector = solver.eigenvectors().col(0);
  return true;
}

}  // namespace diffsac
