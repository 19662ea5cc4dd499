#pragma once

#include <torch/nn/module.h>
#include <torch/nn/modules/linear.h>

#include "diffsac/core/random.h"

namespace diffsac {

/// Marks how a linear layer starts; InitializeParameters carries it out.
enum class LinearStart {
  kDefault,  ///< weight and bias uniform in ±1/sqrt(fan_in), PyTorch's default
  kScaled,   ///< weight normal with the given standard deviation, bias zero (Point-E's init_linear)
  kZero,     ///< all zero (output projection: a new network predicts 0 everywhere)
};

/// Fills a layer from its own random stream, so that a network depends on the seed alone, not on LibTorch's global
/// generator or on the order in which layers were made.
void InitializeLinear(torch::nn::LinearImpl& layer, LinearStart start, double standard_deviation, Rng rng);

}  // namespace diffsac
