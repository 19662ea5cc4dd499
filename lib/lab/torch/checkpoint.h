#pragma once

#include <torch/nn/module.h>
#include <torch/optim/adam.h>

#include <string>

#include "diffsac/guidance/engine/checkpoint_info.h"
#include "lab/torch/exponential_moving_average.h"

namespace diffsac {

/// Writes the average and info and, where there is an optimiser (it may be null), what training goes on from: the
/// weights themselves and the optimiser's state. Whole or not at all. Throws Error naming the path.
void SaveCheckpoint(const std::string& path, const CheckpointInfo& info, const torch::nn::Module& network,
                    const ExponentialMovingAverage& average, const torch::optim::Adam* optimizer);

/// Reads everything into existing objects. Throws Error where training cannot go on from the file, and naming the first
/// tensor whose name or shape differs when the network is another architecture.
CheckpointInfo LoadCheckpoint(const std::string& path, torch::nn::Module& network, ExponentialMovingAverage* average,
                              torch::optim::Adam* optimizer);

/// Reads the averaged weights into `network`, for inference.
CheckpointInfo LoadAverage(const std::string& path, torch::nn::Module& network);

}  // namespace diffsac
