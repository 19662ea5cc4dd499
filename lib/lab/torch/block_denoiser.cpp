#include "lab/torch/block_denoiser.h"

#include <torch/torch.h>

namespace diffsac {

BlockDenoiser::BlockDenoiser(const DenoiserOptions& options, const FeatureColumns& columns, Rng rng)
    : DenoiserBase(options, columns) {
  const std::int64_t width = options.width;
  const auto make = [&](Rng block_rng) { return MakePointBlock(options.kind, width, options.neighbors, block_rng); };
  input_points_ = AddLinear("input_points", columns.width, width, rng);
  encoder_ = AddBlocks("encoder", options.encoder_layers, rng, make);
  ln_encoder_post_ = AddNorm("ln_encoder");
  if (options.inlier_head) inlier_proj_ = AddLinear("inlier_proj", width, 1, rng, true);
  AddConfidenceInput(rng);
  auto hidden = AddLinear("time_hidden", width, width, rng), output = AddLinear("time_output", width, width, rng);
  time_mlp_ = [hidden, output](const torch::Tensor& embedding) mutable {
    return output(torch::silu(hidden(embedding)));
  };
  decoder_ = AddBlocks("decoder", options.layers, rng, make);
  ln_post_ = AddNorm("ln_post");
  output_proj_ = AddLinear("output_proj", width, 1, rng, true);
}

}  // namespace diffsac
