#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "diffsac/geometry/square_bounds.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// First-order distance of a correspondence to the epipolar constraint (Sampson; Luong and Faugeras, IJCV 1996):
/// |x2ᵀ F x1| / sqrt((F x1)₁² + (F x1)₂² + (Fᵀ x2)₁² + (Fᵀ x2)₂²), linear, in the points' unit. Any scale and sign of
/// F. 0 where the two epipoles meet. `f` is row-major.
inline double SampsonDistance(const double* f, double x1, double y1, double x2, double y2) {
  const double a = (f[0] * x1 + f[1] * y1) + f[2];
  const double b = (f[3] * x1 + f[4] * y1) + f[5];
  const double c = (f[6] * x1 + f[7] * y1) + f[8];
  const double d = (f[0] * x2 + f[3] * y2) + f[6];
  const double e = (f[1] * x2 + f[4] * y2) + f[7];
  // The least positive number keeps 0 / 0 away and changes no other quotient.
  const double slope = ((a * a + b * b) + (d * d + e * e)) + std::numeric_limits<double>::min();
  return std::abs((x2 * a + y2 * b) + c) / std::sqrt(slope);
}

/// Sampson distances of points [begin, end) given as 4 columns; equal, bit for bit, to SampsonDistance of each.
void SampsonDistances(const double* f, const double* const* columns, int begin, int end, double* out);

/// Sampson distance of one correspondence x1 y1 x2 y2.
inline double SampsonError(const Matrix3Parameters& model, const double* point) {
  return SampsonDistance(model.data(), point[0], point[1], point[2], point[3]);
}

/// Whether a keypoint turned as the epipolar lines of its match do, within the angle whose cosine is .8 (37°): around a
/// right match the line in image 1, turned as the keypoint did, lies about along that in image 2. Wrong matches turn in
/// any way. turn: the cosine and sine of the second column of Problem::scale_rotation_changes. False at an epipole.
inline bool TurnsAsLines(const double* f, double x1, double y1, double x2, double y2, const double* turn) {
  constexpr double kLeastCosine = 0.8;
  const double a = (f[0] * x1 + f[1] * y1) + f[2];
  const double b = (f[3] * x1 + f[4] * y1) + f[5];
  const double d = (f[0] * x2 + f[3] * y2) + f[6];
  const double e = (f[1] * x2 + f[4] * y2) + f[7];
  // The normals of the two lines point to opposite sides.
  const double along = -((turn[0] * a + turn[1] * b) * d + (turn[0] * b - turn[1] * a) * e);
  return along > 0.0 && along * along > kLeastCosine * kLeastCosine * ((a * a + b * b) * (d * d + e * e));
}

/// What all epipolar models of one matrix have.
struct SampsonModel {
  using Parameters = Matrix3Parameters;
  using Bounds = SampsonBounds;  ///< Of `Residual`.
  static constexpr int kDimension = 4;
  /// Of a Sampson distance, for MAGSAC++.
  static constexpr int kResidualDof = 1;

  /// SampsonError: linear, in the points' unit (a threshold in pixels divided by the focal length for normalised
  /// coordinates).
  static double Residual(const Parameters& model, const double* point) { return SampsonError(model, point); }
  /// As `Residual`, over 4 columns, bit for bit.
  static void Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out) {
    SampsonDistances(model.data(), columns, begin, end, out);
  }
  static bool Turns(const Parameters& model, const double* const* columns, int i, const double* turn) {
    return TurnsAsLines(model.data(), columns[0][i], columns[1][i], columns[2][i], columns[3][i], turn);
  }
};

/// The left null vector of F, of any length; zero when F is zero. It is orthogonal to all columns: the longest cross
/// product of two of them is the safest.
Eigen::Vector3d LeftEpipole(const Eigen::Matrix3d& f);

/// Oriented epipolar constraint (Chum, Werner, Matas, "Epipolar geometry estimation via RANSAC benefits from the
/// oriented epipolar constraint", ICPR 2004): e2 x x2 = λ F x1 with the same sign of λ for all, as for points in front
/// of both cameras. `points` holds `count` rows of four values.
bool SatisfiesOrientation(const Eigen::Matrix3d& f, const double (*points)[4], int count);

/// The nearest matrix of rank 2 in the Frobenius norm.
Eigen::Matrix3d ClosestRankTwo(const Eigen::Matrix3d& f);

/// Weighted normalised 8-point algorithm without a constraint on the singular values (Hartley, PAMI 1997): the matrix
/// of least weighted algebraic error, in the coordinates of `normalization`, which it sets. False when the points of
/// positive weight are fewer than 8 or leave more than one solution.
bool FitEpipolarMatrix(const PointMatrix& points, const Eigen::VectorXd& weights, PairNormalization* normalization,
                       Eigen::Matrix3d* f);

}  // namespace diffsac
