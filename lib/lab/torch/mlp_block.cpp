#include "lab/torch/mlp_block.h"

#include <torch/torch.h>

#include "lab/torch/initialize.h"

namespace diffsac {
namespace nn = torch::nn;

MlpBlock::MlpBlock(std::int64_t width, Rng rng) {
  norm_ = register_module("norm", nn::LayerNorm(nn::LayerNormOptions({width})));
  hidden_ = register_module("hidden", nn::Linear(width, 2 * width));
  output_ = register_module("output", nn::Linear(2 * width, width));
  InitializeLinear(*hidden_, LinearStart::kDefault, 0.0, rng.Fork("hidden"));
  InitializeLinear(*output_, LinearStart::kDefault, 0.0, rng.Fork("output"));
}

torch::Tensor MlpBlock::Forward(const torch::Tensor& x, const torch::Tensor&) {
  return x + output_(torch::gelu(hidden_(norm_(x)), "tanh"));
}

}  // namespace diffsac
