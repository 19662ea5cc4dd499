#pragma once

#include <torch/types.h>

#include "diffsac/guidance/diffusion/noise_schedule.h"

namespace diffsac {

/// c_t = α_t c_0 + σ_t ε, the paper's Eq. (2). `c0` and `noise` [B, …] (the same shape), `t` int64 [B], indices of the
/// schedule; the answer has c0's type and device.
torch::Tensor AddNoise(const NoiseSchedule& schedule, const torch::Tensor& c0, const torch::Tensor& noise,
                       const torch::Tensor& t);

}  // namespace diffsac
