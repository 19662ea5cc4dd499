#include <torch/torch.h>

#include <catch2/catch.hpp>
#include <tuple>
#include <vector>

#include "lab/torch/pooled_block.h"

namespace diffsac {
namespace {

struct Outcome {
  torch::Tensor value, dx;
  std::vector<torch::Tensor> gradients;
};

// Values and gradients of a scalar of the block's output, in the precision of x.
Outcome Run(PooledBlock& block, const torch::Tensor& x, const torch::Tensor& mask, const torch::Tensor& direction) {
  block.zero_grad();
  const auto input = x.detach().clone().requires_grad_();
  const auto y = block.Forward(input, mask);
  (y * direction.to(y.scalar_type())).sum().backward();
  Outcome outcome{y.detach().to(torch::kFloat), input.grad().to(torch::kFloat), {}};
  for (const auto& parameter : block.parameters())
    outcome.gradients.push_back(parameter.grad().to(torch::kFloat).clone());
  return outcome;
}

// Of the largest value; gradients that are 0 but for rounding (the attention's bias, which no softmax sees) count as
// small.
double Apart(const torch::Tensor& a, const torch::Tensor& b) {
  return ((a - b).abs().max() / b.abs().max().clamp_min(1.0)).item<double>();
}

torch::Tensor PrefixMask(const std::vector<std::int64_t>& lengths, std::int64_t points) {
  auto mask = torch::zeros({static_cast<std::int64_t>(lengths.size()), points}, torch::kBool);
  for (std::size_t s = 0; s < lengths.size(); ++s)
    mask[static_cast<std::int64_t>(s)].slice(0, 0, lengths[s]).fill_(true);
  return mask;
}

void CheckAgainstOperations(std::int64_t sets, std::int64_t points, const torch::Tensor& mask) {
  torch::manual_seed(3);
  PooledBlock block(16, Rng(5));
  auto x = 2.0 * torch::randn({sets, points, 16});
  if (points > 3) x.select(1, 2).copy_(x.select(1, 1));  // ties
  auto direction = torch::randn({sets, points, 16});
  if (mask.defined()) direction = direction * mask.unsqueeze(-1);
  const Outcome fused = Run(block, x, mask, direction);
  // Double precision takes the block's own operations.
  block.to(torch::kDouble);
  const Outcome expected = Run(block, x.to(torch::kDouble), mask, direction);
  CHECK(Apart(fused.value, expected.value) < 1e-5);
  CHECK(Apart(fused.dx, expected.dx) < 1e-5);
  for (std::size_t i = 0; i < expected.gradients.size(); ++i) {
    INFO("parameter " << i);
    CHECK(Apart(fused.gradients[i], expected.gradients[i]) < 2e-5);
  }
}

}  // namespace

TEST_CASE("the pooled block's training step: values and gradients are those of its operations") {
  for (const auto& [sets, points] : {std::pair<int, int>{1, 1}, {3, 7}, {20, 40}, {9, 700}})
    CheckAgainstOperations(sets, points, {});
  CheckAgainstOperations(4, 30, PrefixMask({30, 1, 17, 5}, 30));
  CheckAgainstOperations(12, 100, torch::rand({12, 100}) > 0.3);
}

TEST_CASE("the pooled block's training step is the same for any number of threads") {
  torch::manual_seed(4);
  PooledBlock block(16, Rng(6));
  const auto x = torch::randn({19, 50, 16}), direction = torch::randn({19, 50, 16});
  const int before = torch::get_num_threads();
  torch::set_num_threads(1);
  const Outcome one = Run(block, x, {}, direction);
  torch::set_num_threads(3);
  const Outcome three = Run(block, x, {}, direction);
  torch::set_num_threads(before);
  CHECK(torch::equal(one.value, three.value));
  CHECK(torch::equal(one.dx, three.dx));
  for (std::size_t i = 0; i < one.gradients.size(); ++i) CHECK(torch::equal(one.gradients[i], three.gradients[i]));
}

TEST_CASE("the pooled block without gradients is that with them") {
  torch::manual_seed(5);
  PooledBlock block(16, Rng(7));
  const auto x = torch::randn({6, 30, 16}), mask = PrefixMask({30, 1, 17, 5, 30, 2}, 30);
  const auto trained = block.Forward(x, mask);
  const torch::NoGradGuard no_grad;
  CHECK(Apart(trained.detach(), block.Forward(x, mask)) < 1e-5);
}

}  // namespace diffsac
