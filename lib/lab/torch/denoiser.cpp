#include "lab/torch/denoiser.h"

#include <torch/torch.h>

#include "diffsac/core/status.h"
#include "lab/options/options.h"
#include "lab/torch/block_denoiser.h"
#include "lab/torch/point_transformer.h"

namespace diffsac {

std::shared_ptr<Denoiser> MakeDenoiser(const DenoiserOptions& options, const FeatureColumns& columns, Rng rng) {
  CheckOptions(options);
  if (options.relation && columns.first_residual < 0)
    throw Error("network.denoiser.relation: needs network.features.kinds with residual");
  if (options.kind == DenoiserKind::kPointTransformer) return std::make_shared<PointTransformer>(options, columns, rng);
  return std::make_shared<BlockDenoiser>(options, columns, rng);
}

std::int64_t CountParameters(const torch::nn::Module& module) {
  std::int64_t count = 0;
  for (const auto& parameter : module.parameters()) count += parameter.numel();
  return count;
}

}  // namespace diffsac
