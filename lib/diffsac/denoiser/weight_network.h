#pragma once

#include <torch/nn/module.h>
#include <torch/types.h>

#include "diffsac/denoiser/point_batch.h"

namespace diffsac {

/// A network that weighs the points of a problem: the learned part of NG-RANSAC and of CLNet.
///
/// Outputs are equivariant to the order of the points, and a problem's output does not depend on its batch mates.
class WeightNetwork : public torch::nn::Module {
 public:
  /// Weights ≥ 0 [B, N], 0 for padding.
  virtual torch::Tensor Weights(const PointBatch& batch) = 0;
};

}  // namespace diffsac
