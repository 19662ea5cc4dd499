#pragma once

#include <algorithm>

#include "diffsac/geometry/model.h"

namespace diffsac {

/// Solves minimal sets of one point set, which it borrows.
template <MinimalModel Model>
class MinimalSolver {
 public:
  explicit MinimalSolver(const PointMatrix& points) : points_(points) {}

  /// Writes up to kMaxSolutions models of the γ points, returns how many; 0 for a degenerate set and for one with an
  /// index out of range.
  int operator()(const int* set, typename Model::Parameters* models) const {
    const auto is_point = [&](int i) { return i >= 0 && i < points_.rows(); };
    if (!std::all_of(set, set + Model::kMinimalSize, is_point)) return 0;
    return Model::SolveMinimal(points_, set, models);
  }

 private:
  const PointMatrix& points_;
};

}  // namespace diffsac
