#pragma once

#include <functional>

namespace diffsac {

/// Samplers run over any `Value` with sums, differences, products and quotients by a double, and what SampledValue says
/// of it: LibTorch's tensors (lab/torch/tensor_sampler.h) and plain rows of floats
/// (guidance/diffusion/confidence_rows.h).
template <class Value>
struct SampledValue;  // static Value Clamp(const Value&): to [−1, 1]; type Scope, alive while a sampler runs

/// The network: ĉ_0 from c_t, of the same shape. `t` is the schedule's timestep index, 0…T−1 as in diffusers (the
/// paper's t minus 1). The output of a network trained with loss "bce" must be turned into a confidence first.
template <class Value>
using DenoiseFunctionOf = std::function<Value(const Value& c_t, double t)>;

/// Standard normal noise of c_T's shape for step 0, 1, …: the caller draws it, so that it can come from a counter-based
/// generator forked for each problem. Asked for at most once a step, and not where its factor is 0.
template <class Value>
using NoiseFunctionOf = std::function<Value(int step)>;

/// Told once a step, before the update: step number from 0, timestep index, c_t, and the prediction ĉ_0 (clipped when
/// clipping is on).
template <class Value>
using StepObserverOf = std::function<void(int step, double t, const Value& c_t, const Value& c0_hat)>;

}  // namespace diffsac
