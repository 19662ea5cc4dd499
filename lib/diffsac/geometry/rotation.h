#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace diffsac {

/// [v]ₓ, with [v]ₓ w = v × w.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0;
  return matrix;
}

/// The rotation by |v| radians about v, accurate for small v too.
inline Eigen::Quaterniond ExpRotation(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const double half = 0.5 * angle;
  const double factor = angle > 1e-8 ? std::sin(half) / angle : 0.5;
  return Eigen::Quaterniond(std::cos(half), factor * v[0], factor * v[1], factor * v[2]).normalized();
}

/// An orthonormal basis of the plane orthogonal to a unit vector.
inline Eigen::Matrix<double, 3, 2> PlaneBasis(const Eigen::Vector3d& unit) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = unit.unitOrthogonal();
  basis.col(1) = unit.cross(basis.col(0));
  return basis;
}

/// The entries of a matrix, row by row.
inline Eigen::Matrix<double, 9, 1> Flatten(const Eigen::Matrix3d& matrix) {
  Eigen::Matrix<double, 9, 1> flat;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(flat.data()) = matrix;
  return flat;
}

}  // namespace diffsac
