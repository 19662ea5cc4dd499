#include "diffsac/denoiser/frame_denoiser.h"

#include <torch/torch.h>

#include "diffsac/denoiser/initialize.h"
#include "diffsac/denoiser/time_embedding.h"

namespace diffsac {
namespace nn = torch::nn;

namespace {

// [B, κ, N] → [B, κ, N, 1], or [.., 2] with the previous prediction (zeros when there is none yet) behind c_t.
torch::Tensor ConfidenceInput(const torch::Tensor& c_t, const torch::Tensor& previous, bool self_conditioning) {
  if (!self_conditioning) return c_t.unsqueeze(-1);
  return torch::stack({c_t, previous.defined() ? previous : torch::zeros_like(c_t)}, -1);
}

// [B, N] → [B · κ, N]: every copy of a problem has its problem's padding. Undefined stays undefined.
torch::Tensor MaskOfCopies(const torch::Tensor& mask, std::int64_t copies) {
  return mask.defined() ? mask.repeat_interleave(copies, 0) : mask;
}

torch::Tensor Normed(nn::LayerNorm& norm, const torch::Tensor& h) { return norm.is_empty() ? h : norm(h); }

}  // namespace

nn::Linear FrameDenoiser::AddLinear(const char* name, std::int64_t in, std::int64_t out, const Rng& rng, bool zero) {
  auto layer = register_module(name, nn::Linear(in, out));
  InitializeLinear(*layer, zero ? LinearStart::kZero : LinearStart::kDefault, 0.0, rng.Fork(name));
  return layer;
}

nn::LayerNorm FrameDenoiser::AddNorm(const char* name) {
  return register_module(name, nn::LayerNorm(nn::LayerNormOptions({options_.width})));
}

FrameDenoiser::Blocks FrameDenoiser::AddBlocks(const std::string& name, int count, const Rng& rng,
                                               const std::function<std::shared_ptr<PointBlock>(Rng)>& make) {
  Blocks blocks;
  for (int i = 0; i < count; ++i)
    blocks.push_back(register_module(name + std::to_string(i), make(rng.Fork(name, static_cast<std::uint64_t>(i)))));
  return blocks;
}

Context FrameDenoiser::Encode(const PointBatch& batch) {
  Context context;
  context.mask = batch.mask;
  auto h = Normed(ln_encoder_pre_, input_points_(batch.features));
  for (auto& block : encoder_) h = block->Forward(h, batch.mask);
  context.points = Normed(ln_encoder_post_, h);
  if (!inlier_proj_.is_empty()) context.inlier_logits = inlier_proj_(context.points).squeeze(-1);
  return context;
}

torch::Tensor FrameDenoiser::Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t,
                                     const torch::Tensor& previous) {
  const std::int64_t batch = c_t.size(0), copies = c_t.size(1), points = c_t.size(2), width = options_.width;
  const auto time = time_mlp_(TimestepEmbedding(t.expand({batch, copies}), width));
  auto h = input_confidence_(ConfidenceInput(c_t, previous, options_.self_conditioning)) + context.points.unsqueeze(1) +
           time.unsqueeze(2);
  h = Normed(ln_pre_, h.reshape({batch * copies, points, width}));
  const auto mask = MaskOfCopies(context.mask, copies);
  for (auto& block : decoder_) h = block->Forward(h, mask);
  return output_proj_(ln_post_(h)).view({batch, copies, points});
}

}  // namespace diffsac
