#include "lab/torch/exponential_moving_average.h"

#include <torch/torch.h>

#include <algorithm>

namespace diffsac {

ExponentialMovingAverage::ExponentialMovingAverage(const torch::nn::Module& module, double decay) : decay_(decay) {
  torch::NoGradGuard no_grad;
  for (const auto& parameter : module.parameters()) shadow_.push_back(parameter.detach().clone());
}

void ExponentialMovingAverage::Update(const torch::nn::Module& module) {
  torch::NoGradGuard no_grad;
  const double n = static_cast<double>(updates_++);
  const double decay = std::min(decay_, (1.0 + n) / (10.0 + n));
  const auto parameters = module.parameters();
  for (std::size_t i = 0; i < shadow_.size(); ++i) shadow_[i].lerp_(parameters[i].detach(), 1.0 - decay);
}

void ExponentialMovingAverage::CopyTo(torch::nn::Module& module) const {
  torch::NoGradGuard no_grad;
  auto parameters = module.parameters();
  TORCH_CHECK(parameters.size() == shadow_.size(), "the average belongs to another network");
  for (std::size_t i = 0; i < shadow_.size(); ++i) parameters[i].copy_(shadow_[i]);
}

}  // namespace diffsac
