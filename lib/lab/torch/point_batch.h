#pragma once

#include <torch/types.h>

#include <span>
#include <vector>

#include "diffsac/problem/point_features.h"

namespace diffsac {

/// Several problems' point features, padded to the longest.
struct PointBatch {
  torch::Tensor features;  ///< [B, N, D] float; rows past a problem's length are zero.
  torch::Tensor mask;      ///< [B, N] bool, true for real points; undefined when every problem has N points.
  std::vector<std::int64_t> lengths;

  std::int64_t size() const { return features.size(0); }
  std::int64_t max_points() const { return features.size(1); }
  PointBatch To(const torch::Device& device) const;
};

/// Copies feature matrices of the same width into one padded batch. `sets` must not be empty.
PointBatch MakePointBatch(std::span<const FeatureSet* const> sets);

}  // namespace diffsac
