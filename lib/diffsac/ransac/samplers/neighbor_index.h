#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "diffsac/geometry/points.h"

namespace diffsac {

/// Nearest neighbours among the rows of a point matrix by Euclidean distance over all coordinates (a k-d tree, built
/// once). For correspondences these are neighbours in both images. Queries are const and may run at the same time.
class NeighborIndex {
 public:
  /// Copies the points, which must be finite.
  explicit NeighborIndex(const PointMatrix& points);
  ~NeighborIndex();
  NeighborIndex(NeighborIndex&&) noexcept;

  int size() const;
  /// The `count` nearest other points of point `index` (all, when there are fewer), nearest first, the lower index
  /// first where distances tie.
  std::vector<int> Nearest(int index, int count) const;
  /// The `count` points nearest to any place, one coordinate a column of the points; order and ties as above.
  std::vector<int> NearestTo(const double* place, int count) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The edges {i, j}, i < j, of the graph that joins each point with its `count` nearest, ascending, each once.
std::vector<std::pair<int, int>> NeighborEdges(const PointMatrix& points, int count);

/// How much likelier the neighbours of each match make it that it is right: log P(c | right) / P(c | wrong), N values.
/// c of the `neighbors` nearest matches of the first image are among as many nearest of the second image. Of a right
/// match that is half of them; a wrong one has random neighbours there, of which neighbors / (N − 1) are. (Right
/// matches move with those around them: Bian et al., "GMS: grid-based motion statistics", CVPR 2017; Ma et al.,
/// "Locality preserving matching", IJCV 2019.) matches: N × 4, x1 y1 x2 y2, finite, any unit. 0 for fewer than 2 ·
/// neighbors.
Eigen::VectorXd NeighborhoodSupport(const PointMatrix& matches, int neighbors);

}  // namespace diffsac
