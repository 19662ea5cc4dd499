#include "lab/torch/denoiser_base.h"

#include <torch/torch.h>

#include "lab/torch/initialize.h"
#include "lab/torch/time_embedding.h"

namespace diffsac {
namespace nn = torch::nn;

namespace {

// [B, N] → [B · κ, N]: every copy of a problem has its problem's padding. Undefined stays undefined.
torch::Tensor MaskOfCopies(const torch::Tensor& mask, std::int64_t copies) {
  return mask.defined() ? mask.repeat_interleave(copies, 0) : mask;
}

torch::Tensor Normed(nn::LayerNorm& norm, const torch::Tensor& h) { return norm.is_empty() ? h : norm(h); }

}  // namespace

nn::Linear DenoiserBase::AddLinear(const char* name, std::int64_t in, std::int64_t out, const Rng& rng, bool zero) {
  auto layer = register_module(name, nn::Linear(in, out));
  InitializeLinear(*layer, zero ? LinearStart::kZero : LinearStart::kDefault, 0.0, rng.Fork(name));
  return layer;
}

nn::LayerNorm DenoiserBase::AddNorm(const char* name) {
  return register_module(name, nn::LayerNorm(nn::LayerNormOptions({options_.width})));
}

void DenoiserBase::AddConfidenceInput(const Rng& rng) {
  int inputs = 1;
  if (options_.relation) {
    relation_ = register_module("relation", std::make_shared<PointRelation>());
    inputs += PointRelation::kOutputs;
  }
  input_confidence_ = AddLinear("input_confidence", inputs, options_.width, rng);
}

// [B, κ, N, inputs]
torch::Tensor DenoiserBase::ConfidenceInput(const Context& context, const torch::Tensor& c_t) {
  if (!options_.relation) return c_t.unsqueeze(-1);
  std::vector<torch::Tensor> inputs = {c_t};
  for (const auto& related : relation_->Forward(context.agreements, context.mask, c_t)) inputs.push_back(related);
  return torch::stack(inputs, -1);
}

DenoiserBase::Blocks DenoiserBase::AddBlocks(const std::string& name, int count, const Rng& rng,
                                             const std::function<std::shared_ptr<PointBlock>(Rng)>& make) {
  Blocks blocks;
  for (int i = 0; i < count; ++i)
    blocks.push_back(register_module(name + std::to_string(i), make(rng.Fork(name, static_cast<std::uint64_t>(i)))));
  return blocks;
}

Context DenoiserBase::Encode(const PointBatch& batch) {
  Context context;
  context.mask = batch.mask;
  if (options_.relation) context.agreements = PointRelation::Agreements(batch.features, columns_.first_residual);
  auto h = Normed(ln_encoder_pre_, input_points_(batch.features));
  for (auto& block : encoder_) h = block->Forward(h, batch.mask);
  context.points = Normed(ln_encoder_post_, h);
  if (!inlier_proj_.is_empty()) context.inlier_logits = inlier_proj_(context.points).squeeze(-1);
  return context;
}

torch::Tensor DenoiserBase::Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t) {
  const std::int64_t batch = c_t.size(0), copies = c_t.size(1), points = c_t.size(2), width = options_.width;
  const auto time = time_mlp_(TimestepEmbedding(t.expand({batch, copies}), width));
  auto h = input_confidence_(ConfidenceInput(context, c_t)) + context.points.unsqueeze(1) + time.unsqueeze(2);
  h = Normed(ln_pre_, h.reshape({batch * copies, points, width}));
  const auto mask = MaskOfCopies(context.mask, copies);
  for (auto& block : decoder_) h = block->Forward(h, mask);
  return output_proj_(ln_post_(h)).view({batch, copies, points});
}

}  // namespace diffsac
