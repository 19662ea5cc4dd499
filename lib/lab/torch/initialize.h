#pragma once

#include <torch/nn/module.h>
#include <torch/nn/modules/linear.h>

#include "diffsac/core/random.h"

namespace diffsac {

/// How a linear layer starts.
enum class LinearStart {
  kDefault,  ///< weight and bias uniform in ±1/sqrt(fan_in), PyTorch's default
  kScaled,   ///< weight normal with a quarter of 1/sqrt(width), bias zero (Point-E's init_linear)
  kZero,     ///< all zero (output projection: a new network predicts 0 everywhere)
};

/// A layer that starts from its own random stream, so that a network depends on the seed alone, not on LibTorch's
/// global generator or on the order in which layers were made. `width`: of kScaled.
torch::nn::Linear MakeLinear(const torch::nn::LinearOptions& options, const Rng& rng,
                             LinearStart start = LinearStart::kDefault, std::int64_t width = 1);

}  // namespace diffsac
