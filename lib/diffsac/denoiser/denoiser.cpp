#include "diffsac/denoiser/denoiser.h"

#include <torch/torch.h>

#include "diffsac/core/status.h"
#include "diffsac/denoiser/block_denoiser.h"
#include "diffsac/denoiser/point_transformer.h"

namespace diffsac {

void DenoiserOptions::Bind(OptionsBinder& b) {
  b.Field("kind", kind)
      .Help(
          "`point_transformer`: the paper's; `pooled`: point-wise layers with pooled context, for CPUs; the others of "
          "the paper's ablation: `mlp`, each point by itself, `dgcnn`, edge convolutions over nearest points in "
          "feature space");
  const bool transformer = kind == DenoiserKind::kPointTransformer;
  b.Field("width", width, Within(8, 4096)).Help("channels of a point");
  b.Field("heads", heads, Within(1, 64)).OnlyIf(transformer, "kind: point_transformer").Help("attention heads");
  b.Field("encoder_layers", encoder_layers, Within(0, 64))
      .Help("blocks before c_t enters, computed once a problem; 0 is the paper's joint network");
  b.Field("layers", layers, Within(1, 64)).Help("blocks after c_t has entered, computed for each copy and step");
  b.Field("neighbors", neighbors, Within(1, 1024))
      .OnlyIf(kind == DenoiserKind::kDgcnn, "kind: dgcnn")
      .Help("of a point");
  b.Field("inlier_head", inlier_head)
      .Help("a second output: each point's inlier probability, for the learned refit and the inlier head's sets");
  b.Field("relation", relation)
      .Help(
          "each point also sees how much it agrees with the points that are confident now, for several structures; "
          "needs features.kinds: [preference]");
  b.Field("self_conditioning", self_conditioning)
      .Help("the previous ĉ_0 is a second input (Chen et al., \"Analog bits\", 2023)");
  b.Require(width % 2 == 0, "width", "an even number");
  b.Require(!transformer || width % heads == 0, "heads", "a divisor of width");
  b.Require(!inlier_head || encoder_layers > 0, "inlier_head",
            "false when encoder_layers is 0 (nothing to read it from)");
}

std::shared_ptr<Denoiser> MakeDenoiser(const DenoiserOptions& options, const FeatureColumns& columns, Rng rng) {
  CheckOptions(options);
  if (options.relation && columns.first_preference < 0)
    throw Error("network.denoiser.relation: needs network.features.kinds with preference");
  if (options.kind == DenoiserKind::kPointTransformer)
    return std::make_shared<PointTransformer>(options, columns, rng);
  return std::make_shared<BlockDenoiser>(options, columns, rng);
}

std::int64_t CountParameters(const torch::nn::Module& module) {
  std::int64_t count = 0;
  for (const auto& parameter : module.parameters()) count += parameter.numel();
  return count;
}

}  // namespace diffsac
