#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// The signed Sampson residual r of a correspondence and its exact derivative by the nine entries of F (row-major).
/// With c = x2ᵀ F x1, a = (F x1)₁₂, b = (Fᵀ x2)₁₂, d = |a|² + |b|², r = c / √d:
///   dr/dF_ij = (x2_i x1_j − (c/d) ([i<2] a_i x1_j + [j<2] b_j x2_i)) / √d
inline double SampsonResidual(const double* f, const double* point, double* gradient) {
  const double x1 = point[0], y1 = point[1], x2 = point[2], y2 = point[3];
  const double a0 = f[0] * x1 + f[1] * y1 + f[2], a1 = f[3] * x1 + f[4] * y1 + f[5];
  const double b0 = f[0] * x2 + f[3] * y2 + f[6], b1 = f[1] * x2 + f[4] * y2 + f[7];
  const double c = x2 * a0 + y2 * a1 + (f[6] * x1 + f[7] * y1 + f[8]);
  const double inverse = 1.0 / std::sqrt(a0 * a0 + a1 * a1 + b0 * b0 + b1 * b1 + std::numeric_limits<double>::min());
  const double r = c * inverse;
  if (gradient != nullptr) {
    const double k = r * inverse, kb0 = k * b0, kb1 = k * b1;
    const double left[3] = {inverse * (x2 - k * a0), inverse * (y2 - k * a1), inverse};
    const double right[3] = {inverse * x2, inverse * y2, inverse};
    for (int i = 0; i < 3; ++i) {
      gradient[3 * i] = left[i] * x1 - kb0 * right[i];
      gradient[3 * i + 1] = left[i] * y1 - kb1 * right[i];
      gradient[3 * i + 2] = left[i];
    }
  }
  return r;
}

/// JᵀJ and Jᵀr over the nine entries of a 3 x 3 matrix, before they are restricted to a manifold's tangent.
struct NormalEquations {
  Eigen::Matrix<double, 9, 9> normal;
  Matrix3Parameters gradient;
};

/// Weighted sums over signed Sampson residuals (SampsonResidual) of `count` points given as 4 columns; points of weight
/// 0 add nothing. Four points go side by side, whatever the processor's vectors, so the sums are the same everywhere.
NormalEquations SumSampsonEquations(const double* f, const double* const* columns, const double* weights, int count);

}  // namespace diffsac
