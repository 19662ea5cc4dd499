#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// The correspondences of positive weight, normalised and kept as columns, and the moments that the linear fits are
/// made of. One pass over all points gathers them; everything else goes over the gathered ones, several at a time.
class WeightedPairs {
 public:
  /// False for sizes that do not match, a weight that is negative or not finite, fewer than `min_positive` positive
  /// ones, or an image whose points are all equal (up to rounding) or not finite.
  bool Gather(const PointMatrix& points, const Eigen::VectorXd& weights, int min_positive);
  /// The same as they are, not normalised, however few. False for sizes that do not match and unfit weights alone.
  bool Collect(const PointMatrix& points, const Eigen::VectorXd& weights);

  /// Points of positive weight.
  int positive() const { return positive_; }
  /// Moves the points' means to 0, for the normalization; false where Gather is.
  bool Normalize();
  /// x1, y1, x2, y2 (normalised: less their means, not yet scaled) and weights, `positive` rows in the points' order.
  auto columns() const { return columns_.topRows(positive_); }
  const double* column(int j) const { return columns_.col(j).data(); }
  /// Multiplies the coordinates.
  void Scale(double scale) { columns_.leftCols<4>() *= scale; }

  const PairNormalization& normalization() const { return normalization_; }

  /// Σ w s fᵀ over the points, with f = (x1², x1 y1, x1, y1², y1, 1) of the first image and s the same of the second.
  Eigen::Matrix<double, 6, 6> EpipolarMoments() const;
  /// Σ w s fᵀ with s = (1, x2, y2, x2² + y2²).
  Eigen::Matrix<double, 4, 6> TransferMoments() const;

 private:
  int positive_ = 0;
  int count_ = 0;  ///< Rows in use, filled up to whole blocks of lanes with weight 0.
  Eigen::Matrix<double, Eigen::Dynamic, 5> columns_;  ///< x1, y1, x2, y2, weight.
  PairNormalization normalization_;
};

}  // namespace diffsac
