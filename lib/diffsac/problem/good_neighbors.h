#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "diffsac/geometry/points.h"
#include "diffsac/problem/nearest_eight.h"

namespace diffsac {

/// The good matches of a pair, the quarter of lowest ratio (at least 16; all where there are no ratios), and for each
/// match the 8 nearest other ones of these in image 1 and in image 2.
struct GoodNeighbors {
  std::vector<std::int32_t> good;  ///< Rows, ascending.
  std::vector<std::int32_t> own;   ///< N: the number of a match among `good`, or -1.
  /// N of an image: numbers among `good`. Empty for fewer than 9 matches.
  std::array<std::vector<EightNearest>, 2> nearest = {};
};

/// `coordinates`: N × 4, finite. `quality`: N ratios, or empty; NaN ranks last.
GoodNeighbors FindGoodNeighbors(const PointMatrix& coordinates, const Eigen::VectorXd& quality);

/// Coordinates of one image (0 or 1), a column each.
PlanePoints ImagePlane(const PointMatrix& coordinates, int image);
PlanePoints RowsOf(const PlanePoints& plane, const std::vector<std::int32_t>& rows);

}  // namespace diffsac
