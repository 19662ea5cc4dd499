#include "lab/torch/context_block.h"

#include <torch/torch.h>

#include "lab/torch/initialize.h"

namespace diffsac {
namespace nn = torch::nn;

namespace {
constexpr double kLeastVariance = 1e-5;
}

torch::Tensor MeanShares(const torch::Tensor& mask, std::int64_t batch, std::int64_t points,
                         const torch::TensorOptions& options) {
  if (!mask.defined()) return torch::full({batch, 1, points}, 1.0 / static_cast<double>(points), options);
  const auto real = mask.to(options.dtype());
  return (real / real.sum(1, true).clamp_min(1.0)).unsqueeze(1);
}

ContextNorm::ContextNorm(std::int64_t channels) {
  gain_ = register_parameter("gain", torch::ones({channels}));
  shift_ = register_parameter("shift", torch::zeros({channels}));
}

// Both moments are products with the shares, which is much quicker than masked reductions, and the normalisation is one
// multiplication and addition.
torch::Tensor ContextNorm::Forward(const torch::Tensor& input, const torch::Tensor& shares) {
  const auto x = input.to(torch::kFloat);
  const auto mean = torch::bmm(shares, x);
  const auto variance = (torch::bmm(shares, x.square()) - mean.square()).clamp_min(0.0);
  const auto scale = gain_ * (variance + kLeastVariance).rsqrt();
  return torch::relu(torch::addcmul(shift_ - mean * scale, x, scale));
}

ContextBlock::ContextBlock(std::int64_t width, Rng rng) {
  first_ = register_module("first", MakeLinear({width, width}, rng.Fork("first")));
  first_norm_ = register_module("first_norm", std::make_shared<ContextNorm>(width));
  second_ = register_module("second", MakeLinear({width, width}, rng.Fork("second")));
  second_norm_ = register_module("second_norm", std::make_shared<ContextNorm>(width));
}

torch::Tensor ContextBlock::Forward(const torch::Tensor& x, const torch::Tensor& shares) {
  const auto hidden = first_norm_->Forward(first_(x), shares);
  return x + second_norm_->Forward(second_(hidden), shares);
}

}  // namespace diffsac
