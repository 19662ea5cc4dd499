#include "diffsac/denoiser/point_transformer.h"

#include <torch/torch.h>

#include <cmath>

#include "diffsac/denoiser/confidence_input.h"
#include "diffsac/denoiser/initialize.h"
#include "diffsac/denoiser/time_embedding.h"

namespace diffsac {
namespace nn = torch::nn;

TransformerMlp::TransformerMlp(std::int64_t width, double standard_deviation, Rng rng) {
  c_fc_ = register_module("c_fc", nn::Linear(width, 4 * width));
  c_proj_ = register_module("c_proj", nn::Linear(4 * width, width));
  InitializeLinear(*c_fc_, LinearStart::kScaled, standard_deviation, rng.Fork("c_fc"));
  InitializeLinear(*c_proj_, LinearStart::kScaled, standard_deviation, rng.Fork("c_proj"));
}

torch::Tensor TransformerMlp::Forward(const torch::Tensor& x) { return c_proj_(torch::gelu(c_fc_(x))); }

PointAttention::PointAttention(std::int64_t width, std::int64_t heads, double standard_deviation, Rng rng)
    : heads_(heads) {
  c_qkv_ = register_module("c_qkv", nn::Linear(width, 3 * width));
  c_proj_ = register_module("c_proj", nn::Linear(width, width));
  InitializeLinear(*c_qkv_, LinearStart::kScaled, standard_deviation, rng.Fork("c_qkv"));
  InitializeLinear(*c_proj_, LinearStart::kScaled, standard_deviation, rng.Fork("c_proj"));
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

ResidualAttentionBlock::ResidualAttentionBlock(std::int64_t width, std::int64_t heads, double standard_deviation,
                                               Rng rng) {
  attn_ = register_module("attn",
                          std::make_shared<PointAttention>(width, heads, standard_deviation, rng.Fork("attn")));
  ln_1_ = register_module("ln_1", nn::LayerNorm(nn::LayerNormOptions({width})));
  mlp_ = register_module("mlp", std::make_shared<TransformerMlp>(width, standard_deviation, rng.Fork("mlp")));
  ln_2_ = register_module("ln_2", nn::LayerNorm(nn::LayerNormOptions({width})));
}

torch::Tensor ResidualAttentionBlock::Forward(torch::Tensor x, const torch::Tensor& mask) {
  x = x + attn_->Forward(ln_1_(x), mask);
  return x + mlp_->Forward(ln_2_(x));
}

PointTransformer::Blocks PointTransformer::MakeBlocks(const std::string& name, int count, Rng rng) {
  const double standard_deviation = 0.25 * std::sqrt(1.0 / options_.width);
  Blocks blocks;
  for (int i = 0; i < count; ++i) {
    blocks.push_back(register_module(name + std::to_string(i),
                                     std::make_shared<ResidualAttentionBlock>(options_.width, options_.heads,
                                                                              standard_deviation, rng.Fork(name, i))));
  }
  return blocks;
}

PointTransformer::PointTransformer(const DenoiserOptions& options, int input_width, Rng rng) : options_(options) {
  const std::int64_t width = options.width;
  const auto norm = [width] { return nn::LayerNorm(nn::LayerNormOptions({width})); };
  input_points_ = register_module("input_points", nn::Linear(input_width, width));
  input_confidence_ = register_module("input_confidence", nn::Linear(options.self_conditioning ? 2 : 1, width));
  InitializeLinear(*input_points_, LinearStart::kDefault, 0.0, rng.Fork("input_points"));
  InitializeLinear(*input_confidence_, LinearStart::kDefault, 0.0, rng.Fork("input_confidence"));
  time_embed_ = register_module(
      "time_embed",
      std::make_shared<TransformerMlp>(width, 0.25 * std::sqrt(1.0 / options.width), rng.Fork("time_embed")));
  if (options.encoder_layers > 0) {
    ln_encoder_pre_ = register_module("ln_encoder_pre", norm());
    encoder_ = MakeBlocks("encoder", options.encoder_layers, rng);
    ln_encoder_post_ = register_module("ln_encoder_post", norm());
  }
  if (options.inlier_head) {
    inlier_proj_ = register_module("inlier_proj", nn::Linear(width, 1));
    InitializeLinear(*inlier_proj_, LinearStart::kZero, 0.0, rng.Fork("inlier_proj"));
  }
  ln_pre_ = register_module("ln_pre", norm());
  decoder_ = MakeBlocks("block", options.layers, rng);
  ln_post_ = register_module("ln_post", norm());
  output_proj_ = register_module("output_proj", nn::Linear(width, 1));
  InitializeLinear(*output_proj_, LinearStart::kZero, 0.0, rng.Fork("output_proj"));
}

Context PointTransformer::Encode(const PointBatch& batch) {
  Context context;
  context.mask = batch.mask;
  context.points = input_points_(batch.features);
  if (!encoder_.empty()) {
    auto h = ln_encoder_pre_(context.points);
    for (auto& block : encoder_) h = block->Forward(h, batch.mask);
    context.points = ln_encoder_post_(h);
  }
  if (!inlier_proj_.is_empty()) context.inlier_logits = inlier_proj_(context.points).squeeze(-1);
  return context;
}

torch::Tensor PointTransformer::Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t,
                                        const torch::Tensor& previous) {
  const std::int64_t batch = c_t.size(0), copies = c_t.size(1), points = c_t.size(2), width = options_.width;
  const auto time = time_embed_->Forward(TimestepEmbedding(t.expand({batch, copies}), width));
  auto h = input_confidence_(ConfidenceInput(c_t, previous, options_.self_conditioning)) +
           context.points.unsqueeze(1) + time.unsqueeze(2);
  h = ln_pre_(h.reshape({batch * copies, points, width}));
  const auto mask = MaskOfCopies(context.mask, copies);
  for (auto& block : decoder_) h = block->Forward(h, mask);
  return output_proj_(ln_post_(h)).view({batch, copies, points});
}

}  // namespace diffsac
