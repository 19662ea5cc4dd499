#include "diffsac/denoiser/edge_block.h"

#include <torch/torch.h>

#include <algorithm>

#include "diffsac/denoiser/initialize.h"

namespace diffsac {
namespace nn = torch::nn;

torch::Tensor NearestRows(const torch::Tensor& u, const torch::Tensor& mask, std::int64_t k) {
  const torch::NoGradGuard no_grad;
  const auto squares = u.square().sum(-1);
  auto distances = squares.unsqueeze(2) + squares.unsqueeze(1) - 2.0 * torch::bmm(u, u.transpose(1, 2));
  if (mask.defined()) distances = distances.masked_fill(mask.logical_not().unsqueeze(1), 1e9);
  // Whatever the rounding, a point is its own nearest.
  distances.diagonal(0, 1, 2).fill_(-1.0);
  return std::get<1>(distances.topk(std::min(k, u.size(1)), -1, /*largest=*/false));
}

EdgeBlock::EdgeBlock(std::int64_t width, std::int64_t neighbors, Rng rng) : neighbors_(neighbors) {
  norm_ = register_module("norm", nn::LayerNorm(nn::LayerNormOptions({width})));
  own_ = register_module("own", nn::Linear(width, 2 * width));
  difference_ = register_module("difference", nn::Linear(nn::LinearOptions(width, 2 * width).bias(false)));
  output_ = register_module("output", nn::Linear(2 * width, width));
  InitializeLinear(*own_, LinearStart::kDefault, 0.0, rng.Fork("own"));
  InitializeLinear(*difference_, LinearStart::kDefault, 0.0, rng.Fork("difference"));
  InitializeLinear(*output_, LinearStart::kDefault, 0.0, rng.Fork("output"));
}

torch::Tensor EdgeBlock::Forward(const torch::Tensor& x, const torch::Tensor& mask) {
  const auto u = norm_(x);
  const auto nearest = NearestRows(u, mask, neighbors_);  // [S, N, k]
  const std::int64_t sets = u.size(0), points = u.size(1), k = nearest.size(2);
  // A linear layer of a difference is the difference of the layer's outputs: N products instead of N · k.
  const auto mapped = difference_(u);  // [S, N, 2W]
  const std::int64_t columns = mapped.size(2);
  const auto others = mapped.gather(1, nearest.reshape({sets, points * k, 1}).expand({-1, -1, columns}))
                          .view({sets, points, k, columns});
  // gelu is not monotonic: the maximum is taken behind it, as published, and padding is left out there, too.
  auto edges = torch::gelu((own_(u) - mapped).unsqueeze(2) + others, "tanh");
  if (mask.defined()) {
    const auto real = mask.unsqueeze(1).expand({-1, points, -1}).gather(2, nearest);
    edges = edges.masked_fill(real.logical_not().unsqueeze(-1), -1e9);
  }
  return x + output_(edges.amax(2));
}

}  // namespace diffsac
