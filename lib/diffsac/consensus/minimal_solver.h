#pragma once

#include <algorithm>
#include <span>

#include "diffsac/geometry/model.h"

namespace diffsac {

/// Whether every index of a set is a row of so many points.
inline bool AreRows(std::span<const int> set, Eigen::Index points) {
  return std::all_of(set.begin(), set.end(), [&](int i) { return i >= 0 && i < points; });
}

/// Solves minimal sets of one point set, which it borrows.
template <MinimalModel Model>
class MinimalSolver {
 public:
  explicit MinimalSolver(const PointMatrix& points) : points_(points) {}

  /// Writes up to kMaxSolutions models of the γ points, returns how many; 0 for a degenerate set and for one with an
  /// index out of range.
  int operator()(const int* set, typename Model::Parameters* models) const {
    return AreRows({set, Model::kMinimalSize}, points_.rows()) ? Model::SolveMinimal(points_, set, models) : 0;
  }

 private:
  const PointMatrix& points_;
};

}  // namespace diffsac
