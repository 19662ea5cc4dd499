#pragma once

#include <torch/nn/module.h>
#include <torch/optim/adam.h>

#include <string>
#include <vector>

#include "diffsac/core/safetensors.h"

namespace diffsac {

/// Adds `values`, one for each of the network's parameters, as tensors `prefix` + the parameter's name.
void AddTensors(const std::string& prefix, const torch::nn::Module& network, const std::vector<torch::Tensor>& values,
                SafetensorsWriter* writer);

/// Reads them into `targets`, wherever these are. Throws Error naming file and tensor unless the file's tensors of that
/// prefix are those of the network: by number, name, shape and type.
void ReadTensors(const std::string& prefix, const torch::nn::Module& network, const std::vector<torch::Tensor>& targets,
                 SafetensorsFile* file);

/// Adam's state: for each parameter both moments, and the number of its steps.
void AddOptimizer(const torch::nn::Module& network, const torch::optim::Adam& optimizer, SafetensorsWriter* writer);
/// Replaces the state of an optimiser of the network's parameters. Throws Error like ReadTensors.
void ReadOptimizer(const torch::nn::Module& network, torch::optim::Adam* optimizer, SafetensorsFile* file);

}  // namespace diffsac
