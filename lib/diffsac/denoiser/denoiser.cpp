#include "diffsac/denoiser/denoiser.h"

#include <torch/torch.h>

#include "diffsac/denoiser/block_denoiser.h"
#include "diffsac/denoiser/point_transformer.h"

namespace diffsac {

void DenoiserOptions::Bind(OptionsBinder& b) {
  b.Choice("kind", kind, {"point_transformer", "pooled", "mlp", "dgcnn"});
  b.Field("width", width, Within(8, 4096));
  b.Field("heads", heads, Within(1, 64));
  b.Field("encoder_layers", encoder_layers, Within(0, 64));
  b.Field("layers", layers, Within(1, 64));
  b.Field("neighbors", neighbors, Within(1, 1024));
  b.Field("inlier_head", inlier_head);
  b.Field("self_conditioning", self_conditioning);
  b.Require(width % 2 == 0, "width", "an even number");
  b.Require(width % heads == 0, "heads", "a divisor of width");
  b.Require(!inlier_head || encoder_layers > 0, "inlier_head", "false when encoder_layers is 0 (nothing to read it from)");
}

std::shared_ptr<Denoiser> MakeDenoiser(const DenoiserOptions& options, int input_width, Rng rng) {
  if (options.kind == "point_transformer") return std::make_shared<PointTransformer>(options, input_width, rng);
  return std::make_shared<BlockDenoiser>(options, input_width, rng);
}

std::int64_t CountParameters(const torch::nn::Module& module) {
  std::int64_t count = 0;
  for (const auto& parameter : module.parameters()) count += parameter.numel();
  return count;
}

}  // namespace diffsac
