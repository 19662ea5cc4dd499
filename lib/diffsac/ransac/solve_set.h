#pragma once

#include <algorithm>
#include <span>

#include "diffsac/geometry/model.h"

namespace diffsac {

/// Whether every index of a set is a row of so many points.
inline bool AreRows(std::span<const int> set, Eigen::Index points) {
  return std::all_of(set.begin(), set.end(), [&](int i) { return i >= 0 && i < points; });
}

/// Writes up to kMaxSolutions models of the γ points, returns how many; 0 for a degenerate set and for one with an
/// index out of range.
template <MinimalModel Model>
int SolveSet(const PointMatrix& points, const int* set, typename Model::Parameters* models) {
  return AreRows({set, Model::kMinimalSize}, points.rows()) ? Model::SolveMinimal(points, set, models) : 0;
}

}  // namespace diffsac
