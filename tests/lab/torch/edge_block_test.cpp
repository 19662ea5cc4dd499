#include "lab/torch/edge_block.h"

#include <catch2/catch.hpp>

#include "lab/torch/test_networks.h"

namespace diffsac {
namespace {

TEST_CASE("nearest rows are the nearest, the row itself first, and padding comes last") {
  const auto u = RandomTensor({2, 7, 3}, Rng(1));
  auto mask = torch::ones({2, 7}, torch::kBool);
  mask.index_put_({1, torch::indexing::Slice(4)}, false);
  const auto nearest = NearestRows(u, mask, 5);
  REQUIRE(nearest.sizes() == torch::IntArrayRef({2, 7, 5}));
  for (int s = 0; s < 2; ++s) {
    const int real = s == 0 ? 7 : 4;
    for (int i = 0; i < real; ++i) {
      CHECK(nearest[s][i][0].item<int>() == i);
      double last = -1.0;
      for (int j = 0; j < std::min(5, real); ++j) {
        const int other = nearest[s][i][j].item<int>();
        CHECK(other < real);
        const double distance = (u[s][i] - u[s][other]).norm().item<double>();
        CHECK(distance >= last - 1e-5);
        last = distance;
      }
      if (s == 1) CHECK(nearest[s][i][4].item<int>() >= 4);
    }
  }
  CHECK(NearestRows(u, {}, 20).size(2) == 7);
}

TEST_CASE("an edge convolution equals its formula") {
  EdgeBlock block(4, 3, Rng(2));
  const auto x = RandomTensor({1, 6, 4}, Rng(3));
  const torch::NoGradGuard no_grad;
  const auto parameters = block.named_parameters();
  const auto u = torch::layer_norm(x, {4}, parameters["norm.weight"], parameters["norm.bias"])[0];
  const auto nearest = NearestRows(u.unsqueeze(0), {}, 3)[0];
  auto expected = torch::zeros({6, 4});
  for (int i = 0; i < 6; ++i) {
    std::vector<torch::Tensor> edges;
    for (int k = 0; k < 3; ++k) {
      const auto difference = u[nearest[i][k].item<int>()] - u[i];
      edges.push_back(torch::leaky_relu(
          parameters["own.weight"].mv(u[i]) + parameters["own.bias"] + parameters["difference.weight"].mv(difference),
          0.2));
    }
    expected[i] = x[0][i] + parameters["output.weight"].mv(torch::stack(edges).amax(0)) + parameters["output.bias"];
  }
  CHECK(MaxDifference(block.Forward(x, {})[0], expected) < 1e-5);
}

TEST_CASE("padding is no neighbour of an edge convolution, and gradients pass to the neighbours") {
  EdgeBlock block(4, 8, Rng(2));
  const auto real = RandomTensor({1, 5, 4}, Rng(3)).requires_grad_();
  const auto padded = torch::cat({real, torch::full({1, 4, 4}, 7.0)}, 1);
  const auto mask = torch::arange(9).unsqueeze(0) < 5;
  const auto output = block.Forward(padded, mask).slice(1, 0, 5);
  CHECK(MaxDifference(output, block.Forward(real, {})) < 1e-6);
  output[0][0].sum().backward();
  CHECK(real.grad()[0].abs().amax(1).gt(0).sum().item<int>() > 1);
}

TEST_CASE("an edge convolution in double precision is the same") {
  EdgeBlock block(8, 5, Rng(2));
  const auto x = RandomTensor({3, 20, 8}, Rng(3));
  const auto mask = torch::arange(20).unsqueeze(0) < torch::tensor({20, 13, 2}).unsqueeze(1);
  const auto expected = block.Forward(x, mask);
  block.to(torch::kDouble);
  const auto difference = (block.Forward(x.to(torch::kDouble), mask) - expected).masked_select(mask.unsqueeze(-1));
  CHECK(difference.abs().max().item<double>() < 1e-5);
}

TEST_CASE("a set of one point, and fewer points than neighbours, make no trouble") {
  EdgeBlock block(4, 16, Rng(2));
  for (const int points : {1, 2, 5})
    CHECK(block.Forward(RandomTensor({2, points, 4}, Rng(3)), {}).isfinite().all().item<bool>());
}

}  // namespace
}  // namespace diffsac
