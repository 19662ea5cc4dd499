#include "diffsac/geometry/svd3.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <limits>

namespace diffsac {

Svd3 ComputeSvd3(const Eigen::Matrix3d& matrix) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Svd3 result{Eigen::Matrix3d::Constant(kNan), Eigen::Matrix3d::Constant(kNan), Eigen::Vector3d::Constant(kNan)};
  if (!matrix.allFinite()) return result;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.info() != Eigen::Success) return result;
  result.u = svd.matrixU();
  result.v = svd.matrixV();
  result.values = svd.singularValues();
  return result;
}

Svd3 ComputeRotationSvd3(const Eigen::Matrix3d& matrix) {
  Svd3 result = ComputeSvd3(matrix);
  if (result.u.determinant() < 0.0) result.u.col(2) = -result.u.col(2);
  if (result.v.determinant() < 0.0) result.v.col(2) = -result.v.col(2);
  return result;
}

}  // namespace diffsac
