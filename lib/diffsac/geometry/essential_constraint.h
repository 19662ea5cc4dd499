#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// 2 E Eᵀ E - tr(E Eᵀ) E, zero exactly for essential matrices.
inline Eigen::Matrix3d TraceConstraint(const Eigen::Matrix3d& e) {
  const Eigen::Matrix3d gram = e * e.transpose();
  return 2.0 * (gram * e) - gram.trace() * e;
}

/// Its derivative along d.
inline Eigen::Matrix3d TraceConstraintAlong(const Eigen::Matrix3d& e, const Eigen::Matrix3d& gram,
                                            const Eigen::Matrix3d& d) {
  const Eigen::Matrix3d cross = d * e.transpose();
  return 2.0 * ((cross + cross.transpose()) * e + gram * d) - 2.0 * cross.trace() * e - gram.trace() * d;
}

/// Gauss-Newton steps that make members of a family of matrices essential, as long as the constraint gets smaller;
/// returns its last squared size. Roots of eliminated polynomials lose digits near degenerate sets; the constraints
/// themselves have them all. `Family`, whose members have unknowns of which the first kShares are a unit vector:
///   kUnknowns, kShares
///   At(unknowns)               the matrix
///   Along(unknowns, e, k)      its derivative by unknown k, e being At(unknowns)
template <class Family>
double PolishEssential(const Family& family, Eigen::Matrix<double, Family::kUnknowns, 1>* unknowns) {
  constexpr int kSteps = 4;
  constexpr double kGood = 1e-28;
  constexpr int kUnknowns = Family::kUnknowns, kShares = Family::kShares;
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  Eigen::Matrix3d e = family.At(*unknowns);
  Eigen::Matrix3d constraint = TraceConstraint(e);
  double size = constraint.squaredNorm();
  for (int step = 0; step < kSteps && size > kGood; ++step) {
    const Eigen::Matrix3d gram = e * e.transpose();
    Eigen::Matrix<double, 9, kUnknowns> jacobian;
    for (int k = 0; k < kUnknowns; ++k) {
      const Eigen::Matrix3d along = TraceConstraintAlong(e, gram, family.Along(*unknowns, e, k));
      jacobian.col(k) = Eigen::Map<const Matrix3Parameters>(along.data());
    }
    // One more equation keeps the step on the sphere.
    Vector radius = Vector::Zero();
    radius.template head<kShares>() = unknowns->template head<kShares>();
    const Eigen::Matrix<double, kUnknowns, kUnknowns> normal =
        jacobian.transpose() * jacobian + radius * radius.transpose();
    const Vector gradient = jacobian.transpose() * Eigen::Map<const Matrix3Parameters>(constraint.data());
    Vector next = *unknowns - normal.llt().solve(gradient);
    next.template head<kShares>().normalize();
    const Eigen::Matrix3d next_e = family.At(next);
    const Eigen::Matrix3d next_constraint = TraceConstraint(next_e);
    const double next_size = next_constraint.squaredNorm();
    if (!(next_size < size)) break;
    *unknowns = next;
    e = next_e;
    constraint = next_constraint;
    size = next_size;
  }
  return size;
}

}  // namespace diffsac
