#pragma once

#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>

#include <memory>

#include "lab/torch/point_block.h"

namespace diffsac {

// Point-E's transformer (Nichol et al., "Point-E", 2022) over points without positional encoding: the blocks of the
// paper's confidence denoiser.

/// Two linear layers with a GELU between them: width → 4·width → width.
class TransformerMlp : public torch::nn::Module {
 public:
  TransformerMlp(std::int64_t width, Rng rng);
  torch::Tensor Forward(const torch::Tensor& x);

 private:
  torch::nn::Linear c_fc_{nullptr};
  torch::nn::Linear c_proj_{nullptr};
};

/// Multi-head self-attention over points; queries, keys and values are interleaved head by head as in Point-E.
class PointAttention : public torch::nn::Module {
 public:
  PointAttention(std::int64_t width, std::int64_t heads, Rng rng);
  /// x: [S, N, W]; mask: [S, N] bool or undefined, true for real points.
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& mask);

 private:
  std::int64_t heads_;
  torch::nn::Linear c_qkv_{nullptr};
  torch::nn::Linear c_proj_{nullptr};
};

/// x += attention(norm(x)); x += mlp(norm(x)).
class ResidualAttentionBlock : public PointBlock {
 public:
  ResidualAttentionBlock(std::int64_t width, std::int64_t heads, Rng rng);
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& mask) override;

 private:
  torch::nn::LayerNorm ln_1_{nullptr};
  std::shared_ptr<PointAttention> attn_;
  torch::nn::LayerNorm ln_2_{nullptr};
  std::shared_ptr<TransformerMlp> mlp_;
};

}  // namespace diffsac
