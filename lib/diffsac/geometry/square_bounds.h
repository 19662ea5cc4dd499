#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/two_view.h"

namespace diffsac {

// Lower bounds of squared residuals in single precision, for a fraction of what the residuals take. A score that never
// rises with a residual is bounded from above by them, and most models are dropped by that alone. The bounds hold for
// the residuals as computed in double precision: what single precision may be wrong by is taken off
// (square_bounds.cpp).

/// Correspondences with coordinates in [-1, 1], one scale for both images, as columns in single precision.
class FloatPairs {
 public:
  /// columns: x1 y1 x2 y2, `count` values each.
  FloatPairs(const double* const* columns, int count);
  /// Whether bounds are to be had: the points are finite, not all equal, and not far from the origin for their extent.
  bool usable() const { return scale_ > 0.0; }
  /// From the points' unit.
  double scale() const { return scale_; }
  const float* column(int j) const { return columns_.col(j).data(); }
  /// From normalised to given coordinates of image 0 or 1, and back.
  Eigen::Matrix3d ToPoints(int image) const;
  Eigen::Matrix3d FromPoints(int image) const;

 private:
  Eigen::Matrix<float, Eigen::Dynamic, 4> columns_;
  double centre_[4] = {};
  double scale_ = 0.0;
};

/// Squares are summed up in blocks of at most so many.
inline constexpr int kBoundBlock = 128;

/// At least Σ w max(0, 1 − s) over `count` ≤ kBoundBlock squares; no weights: 1 each.
double MsacBound(const float* squares, const float* weights, int count);

/// Bounds of Sampson distances.
class SampsonBounds {
 public:
  /// A model as the bounds take it.
  struct Prepared {
    float f[9];
    float inverse_square;  ///< Of the threshold.
  };

  SampsonBounds(const double* const* columns, int count) : pairs_(columns, count) {}
  /// threshold: linear, in the points' unit. False where no bounds can be given.
  bool Prepare(const Matrix3Parameters& model, double threshold, Prepared* out) const;
  /// At most (residual / threshold)² of points [begin, end).
  void operator()(const Prepared& model, int begin, int end, float* out) const;

 private:
  FloatPairs pairs_;
};

/// Bounds of a homography's Sampson distances.
class HomographyBounds {
 public:
  struct Prepared {
    float h[9];
    float inverse_square;  ///< Of the threshold.
  };

  HomographyBounds(const double* const* columns, int count) : pairs_(columns, count) {}
  bool Prepare(const Matrix3Parameters& model, double threshold, Prepared* out) const;
  void operator()(const Prepared& model, int begin, int end, float* out) const;

 private:
  FloatPairs pairs_;
};

}  // namespace diffsac
