#pragma once

#include "diffsac/core/status.h"
#include "diffsac/geometry/model.h"

namespace diffsac {

/// kOk, or why the points cannot be estimated from: too few, non-finite, all equal or of too low rank.
template <MinimalModel Model>
Status CheckPoints(const PointMatrix& points) {
  if (points.rows() < Model::kMinimalSize) return Status::kTooFewPoints;
  if (points.cols() != Model::kDimension || !points.allFinite()) return Status::kDegenerate;
  if constexpr (requires { Model::Determined(points); }) {
    if (!Model::Determined(points)) return Status::kDegenerate;
  }
  return Status::kOk;
}

}  // namespace diffsac
