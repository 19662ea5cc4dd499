#pragma once

#include "diffsac/geometry/points.h"

namespace diffsac {

/// Where points of no structure might be, in the plane or in space: the ellipsoid of the points' covariance that holds
/// them all. It turns with them. Points that lie on one line or plane have room beside it: no semi-axis is shorter than
/// `least`.
class ChanceEllipsoid {
 public:
  /// threshold: lengths below it are noise.
  ChanceEllipsoid(const PointMatrix& points, double threshold, double least);
  /// Which share of the ellipsoid is within the threshold of a line or plane.
  double ShareNear(const ModelParameters& model) const;

 private:
  double threshold_;
  Eigen::VectorXd centre_;
  Eigen::MatrixXd axes_;  ///< Semi-axes, one a row.
};

}  // namespace diffsac
