#pragma once

#include <cstdint>
#include <vector>

#include "diffsac/geometry/model.h"
#include "diffsac/geometry/points.h"

namespace diffsac {

/// Cubes of the volume of a threshold's ball, about the points of two clouds (N × 3 each), or of more where a side of
/// their box would have more than 2²⁰.
class BallGrid {
 public:
  BallGrid(const PointMatrix& first, const PointMatrix& second, double threshold);
  /// 0 where neither the threshold nor the box has an extent.
  double side() const { return side_; }
  /// Which cube the point of a row is in.
  std::uint64_t CellOf(const PointMatrix& points, Eigen::Index row) const;

 private:
  static constexpr double kMostCells = 1 << 20;  // Along a side.
  Eigen::RowVectorXd least_;
  double side_ = 0.0;
};

/// log10 of the number of motions with as many inliers that unlike clouds would give (LogChanceModels). Above 0 the
/// clouds may share nothing.
///
/// A random match hits as often as a point of the moved first cloud and one of the second share a cell of the volume of
/// the threshold's ball: where the clouds are apart chance gives nothing, and points that many are matched to count as
/// often as the other cloud has points there. Neighbours are matched alike, rightly or not. So matches with both ends
/// in the same two cells count once, and of inliers the cells of the cloud in which they are fewer.
///
/// points: N × 6, x y z of both clouds; model: [s R | t] by columns; inliers: N values, 1 for those; threshold: the
/// greatest distance of an inlier, in the second cloud's unit.
double LogChanceMotions(const PointMatrix& points, const ModelParameters& model,
                        const std::vector<std::uint8_t>& inliers, double threshold);

}  // namespace diffsac
