#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// Whose focal length is unknown: that of both images, which is the same; that of the second image alone; or those of
/// both, each its own. Points of an image of unknown focal length are (x − principal point) / s, s being the likeliest
/// one, in pixels; those of the calibrated one K⁻¹ x.
enum class UnknownFocal { kBoth, kSecond, kEach };

/// How many numbers that is.
constexpr int CountFocals(UnknownFocal unknown) { return unknown == UnknownFocal::kEach ? 2 : 1; }

/// Epipolar geometry with unknown focal lengths: E, row-major, unit Frobenius norm, then f of the first and of the
/// second image in units of s: equal (kBoth), or 1 for the calibrated one.
using FocalParameters = Eigen::Matrix<double, 11, 1>;

/// F = D2 E D1 with D = diag(1, 1, f): x2ᵀ F x1 = 0. `e`: any nine values, row-major.
inline Matrix3Parameters WithFocals(const Matrix3Parameters& e, double focal1, double focal2) {
  Matrix3Parameters f = e;
  f.tail<3>() *= focal2;
  for (int row = 0; row < 3; ++row) f[3 * row + 2] *= focal1;
  return f;
}

inline Matrix3Parameters FundamentalOf(const FocalParameters& model) {
  return WithFocals(model.head<9>(), model[9], model[10]);
}

/// E and the focal lengths as parameters: E scaled to unit norm.
inline FocalParameters AsFocalParameters(const Matrix3Parameters& e, double focal1, double focal2) {
  FocalParameters model;
  model << e / e.norm(), focal1, focal2;
  return model;
}

/// With one length, wherever it is unknown.
inline FocalParameters AsFocalParameters(UnknownFocal unknown, const Matrix3Parameters& e, double focal) {
  return AsFocalParameters(e, unknown == UnknownFocal::kSecond ? 1.0 : focal, focal);
}

/// The points of a model in coordinates K⁻¹ x. `point`: four values.
inline void DivideByFocals(double focal1, double focal2, const double* point, double* out) {
  for (int j = 0; j < 4; ++j) out[j] = point[j] * (1.0 / (j < 2 ? focal1 : focal2));
}

}  // namespace diffsac
