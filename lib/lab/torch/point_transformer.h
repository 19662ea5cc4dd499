#pragma once

#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>

#include <memory>

#include "lab/torch/denoiser_base.h"

namespace diffsac {

/// Two linear layers with a GELU between them: width → 4·width → width.
class TransformerMlp : public torch::nn::Module {
 public:
  TransformerMlp(std::int64_t width, double standard_deviation, Rng rng);
  torch::Tensor Forward(const torch::Tensor& x);

 private:
  torch::nn::Linear c_fc_{nullptr};
  torch::nn::Linear c_proj_{nullptr};
};

/// Multi-head self-attention over points; queries, keys and values are interleaved head by head as in Point-E.
class PointAttention : public torch::nn::Module {
 public:
  PointAttention(std::int64_t width, std::int64_t heads, double standard_deviation, Rng rng);
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
  ResidualAttentionBlock(std::int64_t width, std::int64_t heads, double standard_deviation, Rng rng);
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& mask) override;

 private:
  torch::nn::LayerNorm ln_1_{nullptr};
  std::shared_ptr<PointAttention> attn_;
  torch::nn::LayerNorm ln_2_{nullptr};
  std::shared_ptr<TransformerMlp> mlp_;
};

/// The paper's confidence denoiser: Point-E's transformer (Nichol et al., "Point-E", 2022) over points without
/// positional encoding, on FC(c) + MLP(t) + FC(χ); its output projection starts at zero.
///
/// encoder_layers = 0 is the paper's joint network. Otherwise FC(χ) passes through encoder_layers blocks of its own
/// first, and only `layers` blocks see c_t.
class PointTransformer : public DenoiserBase {
 public:
  PointTransformer(const DenoiserOptions& options, const FeatureColumns& columns, Rng rng);
};

}  // namespace diffsac
