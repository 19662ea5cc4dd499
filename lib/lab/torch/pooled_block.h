#pragma once

#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>

#include "lab/torch/point_block.h"

namespace diffsac {

/// A residual point-wise layer that also sees its set: mean, maximum and a learned softmax pooling of the points
/// (Zaheer et al., "Deep sets", 2017; Lee et al., "Set transformer", 2019). Linear in N.
class PooledBlock : public PointBlock {
 public:
  PooledBlock(std::int64_t width, Rng rng);
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& mask) override;

 private:
  torch::Tensor Pool(const torch::Tensor& u, const torch::Tensor& mask);

  torch::nn::LayerNorm norm_{nullptr};
  torch::nn::Linear attention_{nullptr};
  torch::nn::Linear set_{nullptr};
  torch::nn::Linear point_{nullptr};
  torch::nn::Linear output_{nullptr};
};

}  // namespace diffsac
