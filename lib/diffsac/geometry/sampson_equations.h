#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// JᵀJ and Jᵀr over the nine entries of a 3 x 3 matrix, before they are restricted to a manifold's tangent.
struct NormalEquations {
  Eigen::Matrix<double, 9, 9> normal;
  Matrix3Parameters gradient;
};

/// Weighted sums over signed Sampson residuals (SampsonResidual) of `count` points given as 4 columns; points of weight
/// 0 add nothing. Four points go side by side, whatever the processor's vectors, so the sums are the same everywhere.
NormalEquations SumSampsonEquations(const double* f, const double* const* columns, const double* weights, int count);

}  // namespace diffsac
