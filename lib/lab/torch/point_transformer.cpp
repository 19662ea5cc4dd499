#include "lab/torch/point_transformer.h"

#include <torch/torch.h>

#include <cmath>

#include "lab/torch/initialize.h"

namespace diffsac {
namespace nn = torch::nn;

namespace {

nn::Linear ScaledLinear(std::int64_t in, std::int64_t out, std::int64_t width, const Rng& rng) {
  return MakeLinear({in, out}, rng, LinearStart::kScaled, width);
}

}  // namespace

TransformerMlp::TransformerMlp(std::int64_t width, Rng rng) {
  c_fc_ = register_module("c_fc", ScaledLinear(width, 4 * width, width, rng.Fork("c_fc")));
  c_proj_ = register_module("c_proj", ScaledLinear(4 * width, width, width, rng.Fork("c_proj")));
}

torch::Tensor TransformerMlp::Forward(const torch::Tensor& x) { return c_proj_(torch::gelu(c_fc_(x))); }

PointAttention::PointAttention(std::int64_t width, std::int64_t heads, Rng rng) : heads_(heads) {
  c_qkv_ = register_module("c_qkv", ScaledLinear(width, 3 * width, width, rng.Fork("c_qkv")));
  c_proj_ = register_module("c_proj", ScaledLinear(width, width, width, rng.Fork("c_proj")));
}

torch::Tensor PointAttention::Forward(const torch::Tensor& x, const torch::Tensor& mask) {
  const std::int64_t sets = x.size(0), points = x.size(1), width = x.size(2), head_width = width / heads_;
  // [S, N, H, 3·C] → [S, H, N, 3·C]: each head's q, k and v stand side by side.
  const auto qkv = c_qkv_(x).view({sets, points, heads_, 3 * head_width}).transpose(1, 2);
  const auto parts = qkv.split(head_width, -1);
  const auto key_mask = mask.defined() ? mask.view({sets, 1, 1, points}) : torch::Tensor();
  const auto mixed = torch::scaled_dot_product_attention(
      parts[0], parts[1], parts[2], mask.defined() ? std::optional<torch::Tensor>(key_mask) : std::nullopt);
  return c_proj_(mixed.transpose(1, 2).reshape({sets, points, width}));
}

ResidualAttentionBlock::ResidualAttentionBlock(std::int64_t width, std::int64_t heads, Rng rng) {
  attn_ = register_module("attn", std::make_shared<PointAttention>(width, heads, rng.Fork("attn")));
  ln_1_ = register_module("ln_1", nn::LayerNorm(nn::LayerNormOptions({width})));
  mlp_ = register_module("mlp", std::make_shared<TransformerMlp>(width, rng.Fork("mlp")));
  ln_2_ = register_module("ln_2", nn::LayerNorm(nn::LayerNormOptions({width})));
}

torch::Tensor ResidualAttentionBlock::Forward(const torch::Tensor& x, const torch::Tensor& mask) {
  const auto h = x + attn_->Forward(ln_1_(x), mask);
  return h + mlp_->Forward(ln_2_(h));
}

}  // namespace diffsac
