#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <vector>

#include "diffsac/geometry/pose.h"

namespace diffsac::testing {

/// δᵀ Σ⁺ δ, Σ of this rank.
inline double NormalizedError(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance, int rank) {
  const Eigen::VectorXd unit = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(unit.asDiagonal() * covariance * unit.asDiagonal());
  const Eigen::VectorXd along = solver.eigenvectors().transpose() * unit.cwiseProduct(error);
  return (along.tail(rank).array().square() / solver.eigenvalues().tail(rank).array()).sum();
}

/// The rotation vector that takes `estimate` to `truth`, and the difference of translations.
inline Eigen::VectorXd PoseError(const RelativePose& truth, const RelativePose& estimate) {
  const Eigen::AngleAxisd turn(truth.rotation * estimate.rotation.transpose());
  Eigen::VectorXd error(6);
  error << turn.angle() * turn.axis(), truth.translation - estimate.translation;
  return error;
}

/// What a sample of normalised errors is held against: χ²'s mean, and 5 % beyond its 95 % quantile.
struct NormalizedErrors {
  std::vector<double> values;

  double Mean() const { return Eigen::Map<const Eigen::VectorXd>(values.data(), size()).mean(); }
  double ShareBeyond(double quantile) const {
    return static_cast<double>(std::count_if(values.begin(), values.end(), [&](double v) { return v > quantile; })) /
           static_cast<double>(size());
  }
  Eigen::Index size() const { return static_cast<Eigen::Index>(values.size()); }
};

/// 95 % of χ² with so many degrees of freedom.
inline constexpr double kChiSquare95[] = {0.0, 3.841, 5.991, 7.815, 9.488, 11.070, 12.592, 14.067};

}  // namespace diffsac::testing
