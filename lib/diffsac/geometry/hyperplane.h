#pragma once

#include <Eigen/Core>
#include <cmath>

#include "diffsac/geometry/model.h"

namespace diffsac {

/// A line in the plane (D = 2) or a plane in space (D = 3): n · x + d = 0 with |n| = 1, parameters (n, d).
/// Both are one model: the hyperplane through D points, the weighted total least squares hyperplane otherwise.
template <int D>
struct Hyperplane {
  using Parameters = Eigen::Matrix<double, D + 1, 1>;
  static constexpr int kDimension = D;
  static constexpr int kMinimalSize = D;
  static constexpr int kMaxSolutions = 1;

  /// 0 when the points are equal (lines) or collinear (planes), relative to their own extent.
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out);

  /// Weighted total least squares: n is the direction of least weighted variance, the centroid lies on the model
  /// (Pearson, "On lines and planes of closest fit to systems of points in space", 1901).
  /// False for fewer than D points of positive weight, or when they have no unique fit.
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out);

  /// Whether the points as a whole determine a model: not all equal (lines), not all on one line (planes), finite.
  static bool Determined(const PointMatrix& points);

  /// Residuals of points [begin, end) given as D columns; equal, bit for bit, to `Residual` of each.
  static void Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out);

  /// |n · x + d|.
  static double Residual(const Parameters& model, const double* point) {
    double sum = model[D];
    for (int i = 0; i < D; ++i) sum += model[i] * point[i];
    return std::abs(sum);
  }
};

using Line = Hyperplane<2>;
using Plane = Hyperplane<3>;

extern template struct Hyperplane<2>;
extern template struct Hyperplane<3>;

/// Angle between two hyperplanes' normals in degrees, in [0, 90] (a model and its negative are the same).
double AngleBetweenDegrees(const ModelParameters& a, const ModelParameters& b);

}  // namespace diffsac
