#include "diffsac/denoiser/block_denoiser.h"

#include <torch/torch.h>

#include "diffsac/denoiser/confidence_input.h"
#include "diffsac/denoiser/initialize.h"
#include "diffsac/denoiser/time_embedding.h"

namespace diffsac {
namespace nn = torch::nn;

BlockDenoiser::BlockDenoiser(const DenoiserOptions& options, int input_width, Rng rng) : options_(options) {
  const std::int64_t width = options.width;
  const auto linear = [&](const char* name, std::int64_t in, std::int64_t out, LinearStart start) {
    auto layer = register_module(name, nn::Linear(in, out));
    InitializeLinear(*layer, start, 0.0, rng.Fork(name));
    return layer;
  };
  const auto blocks = [&](const std::string& name, int count) {
    std::vector<std::shared_ptr<PointBlock>> made;
    for (int i = 0; i < count; ++i)
      made.push_back(register_module(name + std::to_string(i),
                                     MakePointBlock(options.kind, width, options.neighbors, rng.Fork(name, i))));
    return made;
  };
  input_points_ = linear("input_points", input_width, width, LinearStart::kDefault);
  encoder_ = blocks("encoder", options.encoder_layers);
  ln_encoder_ = register_module("ln_encoder", nn::LayerNorm(nn::LayerNormOptions({width})));
  if (options.inlier_head) inlier_proj_ = linear("inlier_proj", width, 1, LinearStart::kZero);
  input_confidence_ = linear("input_confidence", options.self_conditioning ? 2 : 1, width, LinearStart::kDefault);
  time_hidden_ = linear("time_hidden", width, width, LinearStart::kDefault);
  time_output_ = linear("time_output", width, width, LinearStart::kDefault);
  decoder_ = blocks("decoder", options.layers);
  ln_post_ = register_module("ln_post", nn::LayerNorm(nn::LayerNormOptions({width})));
  output_proj_ = linear("output_proj", width, 1, LinearStart::kZero);
}

Context BlockDenoiser::Encode(const PointBatch& batch) {
  Context context;
  context.mask = batch.mask;
  auto h = input_points_(batch.features);
  for (auto& block : encoder_) h = block->Forward(h, batch.mask);
  context.points = ln_encoder_(h);
  if (!inlier_proj_.is_empty()) context.inlier_logits = inlier_proj_(context.points).squeeze(-1);
  return context;
}

torch::Tensor BlockDenoiser::Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t,
                                     const torch::Tensor& previous) {
  const std::int64_t batch = c_t.size(0), copies = c_t.size(1), points = c_t.size(2), width = options_.width;
  const auto time = time_output_(torch::silu(time_hidden_(TimestepEmbedding(t.expand({batch, copies}), width))));
  auto h = input_confidence_(ConfidenceInput(c_t, previous, options_.self_conditioning)) + context.points.unsqueeze(1) +
           time.unsqueeze(2);
  h = h.reshape({batch * copies, points, width});
  const auto mask = MaskOfCopies(context.mask, copies);
  for (auto& block : decoder_) h = block->Forward(h, mask);
  return output_proj_(ln_post_(h)).view({batch, copies, points});
}

}  // namespace diffsac
