#include "lab/torch/point_block.h"

#include <torch/torch.h>

#include "lab/torch/edge_block.h"
#include "lab/torch/initialize.h"
#include "lab/torch/point_transformer.h"
#include "lab/torch/pooled_block.h"

namespace diffsac {
namespace nn = torch::nn;

namespace {

class MlpBlock : public PointBlock {
 public:
  MlpBlock(std::int64_t width, const Rng& rng) {
    norm_ = register_module("norm", nn::LayerNorm(nn::LayerNormOptions({width})));
    hidden_ = register_module("hidden", MakeLinear({width, 2 * width}, rng.Fork("hidden")));
    output_ = register_module("output", MakeLinear({2 * width, width}, rng.Fork("output")));
  }
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor&) override {
    return x + output_(torch::gelu(hidden_(norm_(x)), "tanh"));
  }

 private:
  nn::LayerNorm norm_{nullptr};
  nn::Linear hidden_{nullptr};
  nn::Linear output_{nullptr};
};

}  // namespace

std::shared_ptr<PointBlock> MakePointBlock(const DenoiserOptions& options, Rng rng) {
  switch (options.kind) {
    case DenoiserKind::kPointTransformer:
      return std::make_shared<ResidualAttentionBlock>(options.width, options.heads, rng);
    case DenoiserKind::kMlp:
      return std::make_shared<MlpBlock>(options.width, rng);
    case DenoiserKind::kDgcnn:
      return std::make_shared<EdgeBlock>(options.width, options.neighbors, rng);
    case DenoiserKind::kPooled:
      break;
  }
  return std::make_shared<PooledBlock>(options.width, rng);
}

}  // namespace diffsac
