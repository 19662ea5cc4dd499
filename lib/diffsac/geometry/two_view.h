#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/points.h"

namespace diffsac {

/// Parameters of the two-view models: a 3 x 3 matrix, row-major, with unit Frobenius norm (its sign is free).
using Matrix3Parameters = Eigen::Matrix<double, 9, 1>;

/// The parameters as a matrix.
inline Eigen::Matrix3d AsMatrix(const Matrix3Parameters& model) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(model.data());
}

/// A matrix as parameters: scaled to unit Frobenius norm. Not finite when the matrix is zero or not finite.
inline Matrix3Parameters AsParameters(const Eigen::Matrix3d& matrix) {
  Matrix3Parameters model;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(model.data()) = matrix;
  // By the largest entry first, so that squares neither overflow nor vanish.
  model /= model.cwiseAbs().maxCoeff();
  return model / model.norm();
}

/// p -> scale (p - centre): centroid to the origin, root mean square distance to √2 (Hartley, "In defense of the
/// eight-point algorithm", PAMI 1997, takes the mean distance; without roots it is quicker and no worse).
struct ImageNormalization {
  double x = 0.0;      ///< Of the centre.
  double y = 0.0;      ///< Of the centre.
  double scale = 1.0;  ///< After the centre is subtracted.

  /// Of homogeneous points, from p to the normalised point.
  Eigen::Matrix3d Matrix() const {
    Eigen::Matrix3d matrix;
    matrix << scale, 0.0, -scale * x, 0.0, scale, -scale * y, 0.0, 0.0, 1.0;
    return matrix;
  }
  /// From the normalised point back to p.
  Eigen::Matrix3d Inverse() const {
    Eigen::Matrix3d matrix;
    matrix << 1.0 / scale, 0.0, x, 0.0, 1.0 / scale, y, 0.0, 0.0, 1.0;
    return matrix;
  }
};

/// One for each image of the correspondences.
struct PairNormalization {
  ImageNormalization first;   ///< Of x1 y1.
  ImageNormalization second;  ///< Of x2 y2.

  /// A correspondence x1 y1 x2 y2, normalised.
  void Apply(const double* point, double* out) const {
    out[0] = first.scale * (point[0] - first.x);
    out[1] = first.scale * (point[1] - first.y);
    out[2] = second.scale * (point[2] - second.x);
    out[3] = second.scale * (point[3] - second.y);
  }
};

/// From the centre, the mean squared distance to it, and the largest coordinate (in size). False when the points are
/// all equal (up to rounding) or not finite.
bool MakeNormalization(double x, double y, double mean_square, double largest, ImageNormalization* out);

/// Of the rows `set[0..count)`. False when an image's points are all equal (up to rounding) or not finite.
bool NormalizeSet(const PointMatrix& points, const int* set, int count, PairNormalization* out);

/// Whether N x 4 correspondences as a whole can determine a two-view model: finite, at least `min_distinct` of them
/// distinct, and in neither image all on one line.
bool DeterminesTwoViews(const PointMatrix& points, int min_distinct);

}  // namespace diffsac
