#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/bound_block.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

// Lower bounds of squared residuals in single precision, for a fraction of what the residuals take. A score that never
// rises with a residual is bounded from above by them, and most models are dropped by that alone. The bounds hold for
// the residuals as computed in double precision: what single precision may be wrong by is taken off
// (square_bounds.cpp).

/// At least Σ w max(0, 1 − s) over `count` ≤ kBoundBlock squares; no weights: 1 each.
double MsacBound(const float* squares, const float* weights, int count);

/// Bounds of one kind of distance to a matrix. Keeps the correspondences with coordinates in [-1, 1], one scale for
/// both images, as columns in single precision.
class SquareBounds {
 public:
  /// A model as the bounds take it.
  struct Prepared {
    float matrix[9];
    float inverse_square;  ///< Of the threshold.
  };

  /// threshold: linear, in the points' unit. False where no bounds can be given: by points that are not finite, all
  /// equal, or far from the origin for their extent, too.
  bool Prepare(const Matrix3Parameters& model, double threshold, Prepared* out) const;
  /// At most (residual / threshold)² of points [begin, end).
  void operator()(const Prepared& model, int begin, int end, float* out) const;

 protected:
  enum class Kind { kSampson, kHomography };
  /// columns: x1 y1 x2 y2, `count` values each.
  SquareBounds(Kind kind, const double* const* columns, int count);

 private:
  ImageNormalization Normalization(int image) const { return {centre_[2 * image], centre_[2 * image + 1], scale_}; }

  Kind kind_;
  Eigen::Matrix<float, Eigen::Dynamic, 4> columns_;
  double centre_[4] = {};
  double scale_ = 0.0;  ///< From the points' unit; 0 where there are no bounds.
};

/// Bounds of Sampson distances.
struct SampsonBounds : SquareBounds {
  SampsonBounds(const double* const* columns, int count) : SquareBounds(Kind::kSampson, columns, count) {}
};

/// Bounds of a homography's Sampson distances.
struct HomographyBounds : SquareBounds {
  HomographyBounds(const double* const* columns, int count) : SquareBounds(Kind::kHomography, columns, count) {}
};

}  // namespace diffsac
