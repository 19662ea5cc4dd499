#include "lab/train/fused_adam.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>

namespace diffsac {

TEST_CASE("the fused step is Adam's, and its state can go on in either") {
  torch::manual_seed(1);
  torch::nn::Linear a(7, 5), b(7, 5), unused(2, 2);
  {
    const torch::NoGradGuard no_grad;
    b->weight.copy_(a->weight);
    b->bias.copy_(a->bias);
  }
  const auto parameters = [&](torch::nn::Linear& layer) {
    return std::vector<torch::Tensor>{layer->weight, layer->bias, unused->weight};
  };
  const auto options = torch::optim::AdamOptions(0.01);
  torch::optim::Adam ours(parameters(a), options), theirs(parameters(b), options);
  const auto unchanged = unused->weight.detach().clone();
  for (int i = 0; i < 20; ++i) {
    const auto x = torch::randn({9, 7}), target = torch::randn({9, 5});
    for (auto& [layer, optimizer] : {std::pair{&a, &ours}, {&b, &theirs}}) {
      optimizer->zero_grad();
      torch::mse_loss((*layer)->forward(x), target).backward();
    }
    if (i < 15)
      FusedAdamStep(ours);
    else
      ours.step();
    theirs.step();
  }
  CHECK((a->weight - b->weight).abs().max().item<double>() < 1e-5);
  CHECK((a->bias - b->bias).abs().max().item<double>() < 1e-5);
  CHECK(torch::equal(unused->weight, unchanged));
}

}  // namespace diffsac
