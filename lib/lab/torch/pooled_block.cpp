#include "lab/torch/pooled_block.h"

#include <torch/torch.h>

#include "lab/torch/initialize.h"
#include "lab/torch/pooled_function.h"
#include "lab/torch/pooled_kernels.h"

namespace diffsac {
namespace nn = torch::nn;

PooledBlock::PooledBlock(std::int64_t width, Rng rng) {
  norm_ = register_module("norm", nn::LayerNorm(nn::LayerNormOptions({width})));
  attention_ = register_module("attention", MakeLinear({width, kPoolingHeads}, rng.Fork("attention")));
  set_ = register_module("set", MakeLinear({(2 + kPoolingHeads) * width, 2 * width}, rng.Fork("set")));
  point_ = register_module("point", MakeLinear({width, 2 * width}, rng.Fork("point")));
  output_ = register_module("output", MakeLinear({2 * width, width}, rng.Fork("output")));
}

torch::Tensor PooledBlock::Pool(const torch::Tensor& u, const torch::Tensor& mask) {
  auto scores = attention_(u);  // [S, N, H]
  torch::Tensor mean, maximum;
  if (mask.defined()) {
    const auto padding = mask.logical_not().unsqueeze(-1);
    scores = scores.masked_fill(padding, -1e9);
    const auto real = u.masked_fill(padding, 0.0);
    mean = real.sum(1) / mask.sum(1, true).clamp_min(1);
    maximum = u.masked_fill(padding, -1e9).amax(1);
  } else {
    mean = u.mean(1);
    maximum = u.amax(1);
  }
  const auto heads = torch::bmm(scores.softmax(1).transpose(1, 2), u);  // [S, H, W]
  return torch::cat({mean, maximum, heads.flatten(1)}, -1);
}

torch::Tensor PooledBlock::Forward(const torch::Tensor& x, const torch::Tensor& mask) {
  if (HasPooledForward(x))
    return PooledForward(x, mask,
                         {norm_->weight, norm_->bias, attention_->weight, attention_->bias, set_->weight, set_->bias,
                          point_->weight, point_->bias, output_->weight, output_->bias});
  const auto u = norm_(x);
  const auto hidden = point_(u) + set_(Pool(u, mask)).unsqueeze(1);
  return x + output_(torch::gelu(hidden, "tanh"));
}

}  // namespace diffsac
