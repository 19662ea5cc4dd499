#pragma once

#include <torch/types.h>

#include <memory>

#include "diffsac/guidance/diffusion/dpm_solver.h"
#include "diffsac/guidance/diffusion/reverse_sampler.h"

namespace diffsac {

/// Samplers over LibTorch's tensors, on any device.
template <>
struct SampledValue<torch::Tensor> {
  using Scope = torch::NoGradGuard;
  static torch::Tensor Clamp(const torch::Tensor& values) { return values.clamp(-1.0, 1.0); }
};

using DenoiseFunction = DenoiseFunctionOf<torch::Tensor>;
using NoiseFunction = NoiseFunctionOf<torch::Tensor>;
using StepObserver = StepObserverOf<torch::Tensor>;
using ReverseSampler = ReverseSamplerOf<torch::Tensor>;

extern template class ReverseSamplerOf<torch::Tensor>;
extern template torch::Tensor RunDpmSolver(const TimeGrid&, const DpmSolverOptions&, const DenoiseFunction&,
                                           torch::Tensor, const StepObserver&);

/// Throws Error on bad options, steps > T included.
std::unique_ptr<ReverseSampler> MakeReverseSampler(const ReverseSamplerOptions& options, const NoiseSchedule& schedule);

}  // namespace diffsac
