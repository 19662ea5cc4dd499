#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "diffsac/geometry/two_view.h"
#include "diffsac/geometry/unknown_focal.h"

namespace diffsac {

// Each two-view model as a smooth manifold, for refinement:
//   kFreedom                  its dimension
//   From(parameters)          the point for a model (off the manifold: the nearest one's)
//   Parameters()              the 9 values, unit Frobenius norm
//   Tangent()                 9 x kFreedom derivative of Parameters() after Retract(step), at step = 0
//   Retract(step)             the point a step away
// A manifold of which some points are likelier has also
//   Penalty()                 what is added to the cost, a square, at the point
//   AddPenalty(normal, gradient)
//                             its share of the normal equations over the tangent

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

/// Fundamental matrices of cameras with unknown focal lengths: D2 E D1 (FundamentalOf), 5 + 1 dimensions, the last log
/// f, or 5 + 2; or with them held, 5. Parameters() is not of unit norm: Sampson distances do not ask for it.
template <UnknownFocal kUnknown, bool kHeld>
struct FocalManifold {
  static constexpr int kFocals = kHeld ? 0 : CountFocals(kUnknown);
  static constexpr int kFreedom = 5 + kFocals;
  using TangentMatrix = Eigen::Matrix<double, 9, kFreedom>;
  using Step = Eigen::Matrix<double, kFreedom, 1>;
  EssentialManifold essential;
  std::array<double, 2> log_focal;  ///< Of either image.
  /// Of the square of log f less its mean under the prior, `log_median`; where there is one length, the second's.
  std::array<double, 2> prior_weight = {}, log_median = {};

  static FocalManifold From(const FocalParameters& model);
  FocalParameters Model() const;
  Matrix3Parameters Parameters() const;
  TangentMatrix Tangent() const;
  FocalManifold Retract(const Step& step) const;

  double Penalty() const {
    double penalty = 0.0;
    for (int k = 2 - kFocals; k < 2; ++k)
      penalty += prior_weight[k] * (log_focal[k] - log_median[k]) * (log_focal[k] - log_median[k]);
    return penalty;
  }
  void AddPenalty(Eigen::Matrix<double, kFreedom, kFreedom>* normal, Step* gradient) const {
    for (int k = 2 - kFocals, at = 5; k < 2; ++k, ++at) {
      (*normal)(at, at) += prior_weight[k];
      (*gradient)[at] += prior_weight[k] * (log_focal[k] - log_median[k]);
    }
  }
};

}  // namespace diffsac
