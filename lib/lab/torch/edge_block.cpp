#include "lab/torch/edge_block.h"

#include <torch/torch.h>

#include <algorithm>

#include "lab/torch/initialize.h"

namespace diffsac {
namespace nn = torch::nn;

namespace {
constexpr double kLeakySlope = 0.2;  // as published
}

torch::Tensor NearestRows(const torch::Tensor& u, const torch::Tensor& mask, std::int64_t k) {
  const torch::NoGradGuard no_grad;
  // In mixed precision too: products in 16 bits are further apart than neighbours.
  const c10::impl::ExcludeDispatchKeyGuard single(c10::autocast_dispatch_keyset);
  const auto v = u.to(torch::kFloat);
  const auto squares = v.square().sum(-1);
  auto distances = squares.unsqueeze(2) + squares.unsqueeze(1) - 2.0 * torch::bmm(v, v.transpose(1, 2));
  if (mask.defined()) distances = distances.masked_fill(mask.logical_not().unsqueeze(1), 1e9);
  // Whatever the rounding, a point is its own nearest.
  distances.diagonal(0, 1, 2).fill_(-1.0);
  return std::get<1>(distances.topk(std::min(k, u.size(1)), -1, /*largest=*/false));
}

EdgeBlock::EdgeBlock(std::int64_t width, std::int64_t neighbors, Rng rng) : neighbors_(neighbors) {
  norm_ = register_module("norm", nn::LayerNorm(nn::LayerNormOptions({width})));
  own_ = register_module("own", MakeLinear({width, 2 * width}, rng.Fork("own")));
  difference_ = register_module("difference",
                                MakeLinear(nn::LinearOptions(width, 2 * width).bias(false), rng.Fork("difference")));
  output_ = register_module("output", MakeLinear({2 * width, width}, rng.Fork("output")));
}

namespace {

// Which neighbour has the largest value of each channel, [S, N, C]; values: [S, N, C], nearest: [S, N, k].
torch::Tensor Winners(const torch::Tensor& values, const torch::Tensor& nearest) {
  const std::int64_t sets = values.size(0), points = values.size(1);
  const auto rows = values.reshape({-1, values.size(2)});
  const auto first = torch::arange(sets, nearest.options()).mul_(points).unsqueeze(1);
  torch::Tensor winners, largest;
  for (std::int64_t k = 0; k < nearest.size(2); ++k) {
    const auto neighbor = nearest.select(2, k);
    const auto value = rows.index_select(0, (neighbor + first).flatten()).view(values.sizes());
    const auto index = neighbor.unsqueeze(2).expand(values.sizes());
    winners = k == 0 ? index : torch::where(value > largest, index, winners);
    largest = k == 0 ? value : torch::maximum(largest, value);
  }
  return winners;
}

// For each point and channel the largest value among the point's neighbours. Which one has it is found without a graph,
// and only its value is taken with one: k times less to differentiate.
torch::Tensor LargestOfNeighbors(const torch::Tensor& values, const torch::Tensor& nearest, const torch::Tensor& mask) {
  torch::Tensor winners;
  {
    const torch::NoGradGuard no_grad;
    const auto known = mask.defined() ? values.masked_fill(mask.logical_not().unsqueeze(-1), -1e9) : values;
    winners = Winners(known, nearest);
  }
  return values.gather(1, winners);
}

}  // namespace

torch::Tensor EdgeBlock::Forward(const torch::Tensor& x, const torch::Tensor& mask) {
  const auto u = norm_(x);
  // A linear layer of a difference is the difference of the layer's outputs (N products instead of N · k), and a
  // maximum behind an activation that rises everywhere is the activation of the maximum.
  const auto mapped = difference_(u);  // [S, N, 2W]
  const auto largest = LargestOfNeighbors(mapped, NearestRows(u, mask, neighbors_), mask);
  return x + output_(torch::leaky_relu(own_(u) - mapped + largest, kLeakySlope));
}

}  // namespace diffsac
