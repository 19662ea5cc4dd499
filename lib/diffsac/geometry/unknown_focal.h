#pragma once

#include <Eigen/Core>
#include <cmath>

#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// Whose focal length is unknown: that of both images, which is the same, or that of the second image alone. Points of
/// an image of unknown focal length are (x − principal point) / s, s being the likeliest one, in pixels; those of the
/// calibrated one K⁻¹ x.
enum class UnknownFocal { kBoth, kSecond };

/// Epipolar geometry with an unknown focal length: E, row-major, unit Frobenius norm, then f in units of s.
using FocalParameters = Eigen::Matrix<double, 10, 1>;

/// F = D2 E D1 with D = diag(1, 1, f) for images of unknown focal length, else I: x2ᵀ F x1 = 0. `e`: any nine values,
/// row-major.
inline Matrix3Parameters WithFocal(UnknownFocal unknown, const Matrix3Parameters& e, double focal) {
  Matrix3Parameters f = e;
  f.tail<3>() *= focal;
  if (unknown == UnknownFocal::kBoth)
    for (int row = 0; row < 3; ++row) f[3 * row + 2] *= focal;
  return f;
}

inline Matrix3Parameters FundamentalOf(UnknownFocal unknown, const FocalParameters& model) {
  return WithFocal(unknown, model.head<9>(), model[9]);
}

/// E and f as parameters: E scaled to unit norm.
inline FocalParameters AsFocalParameters(const Matrix3Parameters& e, double focal) {
  FocalParameters model;
  model << e / e.norm(), focal;
  return model;
}

/// The points of a model in coordinates K⁻¹ x. `point`: four values.
inline void DivideByFocal(UnknownFocal unknown, double focal, const double* point, double* out) {
  const double first = unknown == UnknownFocal::kBoth ? 1.0 / focal : 1.0;
  for (int j = 0; j < 4; ++j) out[j] = point[j] * (j < 2 ? first : 1.0 / focal);
}

}  // namespace diffsac
