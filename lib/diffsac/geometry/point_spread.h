#pragma once

#include "diffsac/geometry/points.h"

namespace diffsac {

/// How far points reach, by their covariance: a turn of the coordinates turns it, and changes no length.
struct PointSpread {
  Eigen::VectorXd centre;  ///< The mean.
  Eigen::MatrixXd axes;    ///< Principal directions, one a column, that of least spread first.
  Eigen::VectorXd sides;   ///< Along these: √12 σ, the sides of the box that uniform points of this covariance fill.
};

/// Zero where there are no points.
PointSpread SpreadOf(const PointMatrix& points);

}  // namespace diffsac
