#pragma once

#include <torch/nn/module.h>
#include <torch/optim/adam.h>

#include <cstdint>
#include <string>
#include <vector>

#include "diffsac/denoiser/exponential_moving_average.h"

namespace diffsac {

/// Sums of the parts of the loss over the steps since the last row of metrics.
struct LossSums {
  std::vector<double> sums;
  std::int64_t steps = 0;
};

/// What a checkpoint says about itself.
struct CheckpointInfo {
  std::string method, task;    ///< That the network was trained by and for.
  std::string config;          ///< The resolved training configuration, YAML.
  std::string git_revision;    ///< Of the program that wrote it.
  std::int64_t iteration = 0;  ///< Optimiser steps done. Data, noise and times of each step are drawn from
                               ///< (seed, iteration), so this is the whole random state.
  std::uint64_t seed = 0;
  double best_validation = -1;  ///< Best validation mAA so far, −1 before the first.
  LossSums losses = {};         ///< Only where training can resume; none in files of earlier versions.
};

// A checkpoint is a safetensors file (core/safetensors.h; docs/reliability.md): tensors `network.*`, `average.*` and,
// where training can resume, `optimizer.*`, named by the network's parameters, and the info as the file's metadata.

/// Writes weights, average, optimiser (may be null) and info, whole or not at all. Throws Error naming the path.
void SaveCheckpoint(const std::string& path, const CheckpointInfo& info, const torch::nn::Module& network,
                    const ExponentialMovingAverage& average, const torch::optim::Adam* optimizer);

/// Reads the info alone. Throws Error when the file is missing, damaged or of another program or version.
CheckpointInfo ReadCheckpointInfo(const std::string& path);

/// Reads everything into existing objects (average and optimizer may be null). Throws Error naming the first tensor
/// whose name or shape differs when the network is another architecture.
CheckpointInfo LoadCheckpoint(const std::string& path, torch::nn::Module& network, ExponentialMovingAverage* average,
                              torch::optim::Adam* optimizer);

/// Reads the averaged weights into `network`, for inference.
CheckpointInfo LoadAverage(const std::string& path, torch::nn::Module& network);

}  // namespace diffsac
