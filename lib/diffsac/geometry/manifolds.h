#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "diffsac/geometry/two_view.h"

namespace diffsac {

// Each two-view model as a smooth manifold, for refinement:
//   kFreedom                  its dimension
//   From(parameters)          the point for a model (off the manifold: the nearest one's)
//   Parameters()              the 9 values, unit Frobenius norm
//   Tangent()                 9 x kFreedom derivative of Parameters() after Retract(step), at step = 0
//   Retract(step)             the point a step away

/// Homographies: the unit sphere of 9-vectors, 8 dimensions.
struct HomographyManifold {
  static constexpr int kFreedom = 8;
  Matrix3Parameters h;

  static HomographyManifold From(const Matrix3Parameters& model);
  Matrix3Parameters Parameters() const { return h; }
  Eigen::Matrix<double, 9, 8> Tangent() const;
  HomographyManifold Retract(const Eigen::Matrix<double, 8, 1>& step) const;
};

/// Matrices of rank 2 up to scale: U diag(cos α, sin α, 0) Vᵀ with U, V in SO(3), 3 + 3 + 1 dimensions
/// (Bartoli and Sturm, "Nonlinear estimation of the fundamental matrix with minimal parameters", PAMI 2004).
struct FundamentalManifold {
  static constexpr int kFreedom = 7;
  Eigen::Quaterniond u, v;
  double angle;

  static FundamentalManifold From(const Matrix3Parameters& model);
  Matrix3Parameters Parameters() const;
  Eigen::Matrix<double, 9, 7> Tangent() const;
  FundamentalManifold Retract(const Eigen::Matrix<double, 7, 1>& step) const;
};

/// Essential matrices up to scale: [t]ₓ R / √2 with R in SO(3) and t on the unit sphere, 3 + 2 dimensions.
struct EssentialManifold {
  static constexpr int kFreedom = 5;
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;

  static EssentialManifold From(const Matrix3Parameters& model);
  Matrix3Parameters Parameters() const;
  Eigen::Matrix<double, 9, 5> Tangent() const;
  EssentialManifold Retract(const Eigen::Matrix<double, 5, 1>& step) const;
};

}  // namespace diffsac
