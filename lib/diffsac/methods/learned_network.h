#pragma once

#include <torch/nn/module.h>

#include <cstdint>
#include <memory>
#include <string>

#include "diffsac/core/options.h"
#include "diffsac/data/point_features.h"
#include "diffsac/data/problem.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// A network of a learned method with the features it reads: what training changes, checkpoints keep and rows use.
/// Each method's own struct adds its typed network and its options.
struct LearnedNetwork {
  Task task;
  PointFeaturesOptions feature_options;
  PointFeatures features;
  std::shared_ptr<torch::nn::Module> module;  ///< Set by the method's own constructor.
  torch::Device device = torch::kCPU;
  TrainingFacts facts;  ///< Of a loaded network.

  void MoveTo(const torch::Device& target);

 protected:
  LearnedNetwork(Task task_value, const PointFeaturesOptions& options)
      : task(task_value), feature_options(options), features(options, task_value) {}
};

/// The training configuration that a checkpoint carries, read once for all who ask for something of it.
struct TrainedConfig {
  std::string checkpoint;  ///< Its file.
  std::string method;      ///< That trained it.
  Task task{};
  Config config;
  std::string model;  ///< By which of the task's models its minimal sets are solved; empty: the task's own.
  std::uint64_t seed = 0;
  TrainingFacts facts;  ///< Without the number of parameters, which the network knows.
};

/// Throws Error naming the file when it is no checkpoint.
TrainedConfig ReadTrainedConfig(const std::string& checkpoint);
/// Throws Error naming the file when it was trained by another method or for another task.
void CheckTrainedFor(const TrainedConfig& trained, const std::string& method, Task task);
/// Both.
TrainedConfig ReadTrainedConfig(const std::string& checkpoint, const std::string& method, Task task);

/// Gives a network that was made as `trained` says its averaged weights, ready for inference on `device`. Throws Error
/// naming the file and the first weight that differs.
void LoadWeights(const TrainedConfig& trained, const torch::Device& device, LearnedNetwork* network);

/// "auto" (CUDA where LibTorch has it and a device is there), "cpu", "cuda" or "cuda:1". Throws Error when CUDA is
/// asked for in vain.
torch::Device DeviceFromString(const std::string& name);

}  // namespace diffsac
