#pragma once

#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>

#include "lab/torch/point_block.h"

namespace diffsac {

/// A residual layer of each point by itself, "MLPs" of the paper's ablation (e): x + B gelu(A norm(x)), A to twice the
/// width. No point sees another one.
class MlpBlock : public PointBlock {
 public:
  MlpBlock(std::int64_t width, Rng rng);
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& mask) override;

 private:
  torch::nn::LayerNorm norm_{nullptr};
  torch::nn::Linear hidden_{nullptr};
  torch::nn::Linear output_{nullptr};
};

}  // namespace diffsac
