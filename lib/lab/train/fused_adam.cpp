#include "lab/train/fused_adam.h"

#include <torch/torch.h>

#include <memory>
#include <vector>

namespace diffsac {
namespace {

using torch::optim::AdamOptions;
using torch::optim::AdamParamState;

// Adam's state of a parameter, zeros before its first step.
AdamParamState& StateOf(torch::optim::Adam& optimizer, const torch::Tensor& parameter) {
  auto& slot = optimizer.state()[parameter.unsafeGetTensorImpl()];
  if (slot == nullptr) {
    auto state = std::make_unique<AdamParamState>();
    state->step(0);
    state->exp_avg(torch::zeros_like(parameter));
    state->exp_avg_sq(torch::zeros_like(parameter));
    slot = std::move(state);
  }
  return static_cast<AdamParamState&>(*slot);
}

}  // namespace

void FusedAdamStep(torch::optim::Adam& optimizer) {
  const torch::NoGradGuard no_grad;
  for (auto& group : optimizer.param_groups()) {
    const auto& options = static_cast<const AdamOptions&>(group.options());
    TORCH_CHECK(!options.amsgrad(), "amsgrad is not for the fused step");
    std::vector<torch::Tensor> parameters, gradients, means, squares, steps;
    for (const auto& parameter : group.params()) {
      if (!parameter.grad().defined()) continue;
      auto& state = StateOf(optimizer, parameter);
      state.step(state.step() + 1);
      parameters.push_back(parameter);
      gradients.push_back(parameter.grad());
      means.push_back(state.exp_avg());
      squares.push_back(state.exp_avg_sq());
      steps.push_back(torch::full({}, static_cast<double>(state.step()), parameter.options().requires_grad(false)));
    }
    if (parameters.empty()) continue;
    const auto [beta1, beta2] = options.betas();
    at::_fused_adam_(parameters, gradients, means, squares, {}, steps, options.lr(), beta1, beta2,
                     options.weight_decay(), options.eps(), false, false);
  }
}

}  // namespace diffsac
