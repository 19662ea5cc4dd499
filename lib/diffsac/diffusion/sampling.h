#pragma once

#include <torch/types.h>

#include <functional>

namespace diffsac {

/// The network: ĉ_0 from c_t, of the same shape. `t` is the schedule's timestep index, 0…T−1 as in diffusers (the
/// paper's t minus 1); it lies between two indices for spacings that are uniform in λ and for the middle of a 2S step.
/// A network trained by DiffusionLoss "bce" must be wrapped by LogitsToConfidence.
using DenoiseFunction = std::function<torch::Tensor(const torch::Tensor& c_t, double t)>;

/// Standard normal noise of c_T's shape for step 0, 1, …: the caller draws it, so that it can come from a counter-based
/// generator forked for each problem. Asked for at most once a step, and not where its factor is 0.
using NoiseFunction = std::function<torch::Tensor(int step)>;

/// Told once a step, before the update: step number from 0, timestep index, c_t, and the prediction ĉ_0 (clipped when
/// clipping is on).
using StepObserver = std::function<void(int step, double t, const torch::Tensor& c_t, const torch::Tensor& c0_hat)>;

}  // namespace diffsac
