#include "lab/torch/exponential_moving_average.h"

#include <catch2/catch.hpp>

#include <algorithm>

#include "lab/torch/test_networks.h"

namespace diffsac {

TEST_CASE("the average follows shadow = d·shadow + (1 − d)·weight with a warm-up") {
  auto network = std::make_shared<Denoiser>(SmallOptions("pooled"), 3, Rng(1));
  const torch::NoGradGuard no_grad;
  for (auto& p : network->parameters()) p.fill_(1.0);
  ExponentialMovingAverage average(*network, 0.5);
  for (auto& p : network->parameters()) p.fill_(3.0);
  double expected = 1.0;
  for (int n = 0; n < 12; ++n) {
    average.Update(*network);
    const double d = std::min(0.5, (1.0 + n) / (10.0 + n));
    expected = d * expected + (1.0 - d) * 3.0;
    CHECK(average.shadow()[0].flatten()[0].item<float>() == Approx(expected));
  }
  CHECK(average.updates() == 12);
  average.CopyTo(*network);
  CHECK(network->parameters()[2].flatten()[0].item<float>() == Approx(expected));
}

}  // namespace diffsac
