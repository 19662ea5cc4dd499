#pragma once

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

}  // namespace diffsac
