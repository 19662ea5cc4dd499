#include "lab/torch/denoiser.h"

#include <torch/torch.h>

#include <cmath>

#include "diffsac/core/status.h"
#include "lab/options/options.h"
#include "lab/torch/initialize.h"
#include "lab/torch/point_transformer.h"

namespace diffsac {
namespace nn = torch::nn;

namespace {

// [B, N] → [B · κ, N]: every copy of a problem has its problem's padding. Undefined stays undefined.
torch::Tensor MaskOfCopies(const torch::Tensor& mask, std::int64_t copies) {
  return mask.defined() ? mask.repeat_interleave(copies, 0) : mask;
}

torch::Tensor Normed(nn::LayerNorm& norm, const torch::Tensor& h) { return norm.is_empty() ? h : norm(h); }

}  // namespace

Denoiser::Denoiser(const DenoiserOptions& options, const FeatureColumns& columns, Rng rng)
    : options_(options), columns_(columns) {
  CheckOptions(options);
  if (options.relation && columns.first_residual < 0)
    throw Error("network.denoiser.relation: needs network.features.kinds with residual");
  input_points_ = AddLinear("input_points", columns.width, options.width, rng);
  if (options.kind == DenoiserKind::kPointTransformer)
    AddTransformer(rng);
  else
    AddPointwise(rng);
  ln_post_ = AddNorm("ln_post");
  output_proj_ = AddLinear("output_proj", options.width, 1, rng, true);
}

void Denoiser::AddTransformer(const Rng& rng) {
  AddConfidenceInput(rng);
  const auto time =
      register_module("time_embed", std::make_shared<TransformerMlp>(options_.width, rng.Fork("time_embed")));
  time_mlp_ = [time](const torch::Tensor& embedding) { return time->Forward(embedding); };
  if (options_.encoder_layers > 0) {
    ln_encoder_pre_ = AddNorm("ln_encoder_pre");
    encoder_ = AddBlocks("encoder", options_.encoder_layers, rng);
    ln_encoder_post_ = AddNorm("ln_encoder_post");
  }
  AddInlierHead(rng);
  ln_pre_ = AddNorm("ln_pre");
  decoder_ = AddBlocks("block", options_.layers, rng);
}

void Denoiser::AddPointwise(const Rng& rng) {
  encoder_ = AddBlocks("encoder", options_.encoder_layers, rng);
  ln_encoder_post_ = AddNorm("ln_encoder");
  AddInlierHead(rng);
  AddConfidenceInput(rng);
  const int width = options_.width;
  auto hidden = AddLinear("time_hidden", width, width, rng), output = AddLinear("time_output", width, width, rng);
  time_mlp_ = [hidden, output](const torch::Tensor& embedding) mutable {
    return output(torch::silu(hidden(embedding)));
  };
  decoder_ = AddBlocks("decoder", options_.layers, rng);
}

void Denoiser::AddInlierHead(const Rng& rng) {
  if (options_.inlier_head) inlier_proj_ = AddLinear("inlier_proj", options_.width, 1, rng, true);
}

nn::Linear Denoiser::AddLinear(const char* name, std::int64_t in, std::int64_t out, const Rng& rng, bool zero) {
  return register_module(name,
                         MakeLinear({in, out}, rng.Fork(name), zero ? LinearStart::kZero : LinearStart::kDefault));
}

nn::LayerNorm Denoiser::AddNorm(const char* name) {
  return register_module(name, nn::LayerNorm(nn::LayerNormOptions({options_.width})));
}

void Denoiser::AddConfidenceInput(const Rng& rng) {
  int inputs = 1;
  if (options_.relation) {
    relation_ = register_module("relation", std::make_shared<PointRelation>());
    inputs += PointRelation::kOutputs;
  }
  input_confidence_ = AddLinear("input_confidence", inputs, options_.width, rng);
}

// [B, κ, N, inputs]
torch::Tensor Denoiser::ConfidenceInput(const Context& context, const torch::Tensor& c_t) {
  if (!options_.relation) return c_t.unsqueeze(-1);
  std::vector<torch::Tensor> inputs = {c_t};
  for (const auto& related : relation_->Forward(context.agreements, context.mask, c_t)) inputs.push_back(related);
  return torch::stack(inputs, -1);
}

Denoiser::Blocks Denoiser::AddBlocks(const std::string& name, int count, const Rng& rng) {
  Blocks blocks;
  for (int i = 0; i < count; ++i)
    blocks.push_back(register_module(name + std::to_string(i),
                                     MakePointBlock(options_, rng.Fork(name, static_cast<std::uint64_t>(i)))));
  return blocks;
}

Context Denoiser::Encode(const PointBatch& batch) {
  Context context;
  context.mask = batch.mask;
  if (options_.relation) context.agreements = PointRelation::Agreements(batch.features, columns_.first_residual);
  auto h = Normed(ln_encoder_pre_, input_points_(batch.features));
  for (auto& block : encoder_) h = block->Forward(h, batch.mask);
  context.points = Normed(ln_encoder_post_, h);
  if (!inlier_proj_.is_empty()) context.inlier_logits = inlier_proj_(context.points).squeeze(-1);
  return context;
}

torch::Tensor Denoiser::Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t) {
  const std::int64_t batch = c_t.size(0), copies = c_t.size(1), points = c_t.size(2), width = options_.width;
  const auto time = time_mlp_(TimestepEmbedding(t.expand({batch, copies}), width));
  auto h = input_confidence_(ConfidenceInput(context, c_t)) + context.points.unsqueeze(1) + time.unsqueeze(2);
  h = Normed(ln_pre_, h.reshape({batch * copies, points, width}));
  const auto mask = MaskOfCopies(context.mask, copies);
  for (auto& block : decoder_) h = block->Forward(h, mask);
  return output_proj_(ln_post_(h)).view({batch, copies, points});
}

torch::Tensor TimestepEmbedding(const torch::Tensor& t, std::int64_t width) {
  TORCH_CHECK(width % 2 == 0, "the time embedding's width must be even, got ", width);
  const std::int64_t half = width / 2;
  const auto frequencies = torch::exp(torch::arange(half, t.options().dtype(torch::kFloat)) *
                                      (-std::log(10000.0) / static_cast<double>(half)));
  const auto angles = t.to(torch::kFloat).unsqueeze(-1) * frequencies;
  return torch::cat({angles.cos(), angles.sin()}, -1);
}

std::int64_t CountParameters(const torch::nn::Module& module) {
  std::int64_t count = 0;
  for (const auto& parameter : module.parameters()) count += parameter.numel();
  return count;
}

}  // namespace diffsac
