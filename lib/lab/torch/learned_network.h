#pragma once

#include <torch/nn/module.h>

#include <memory>
#include <string>

#include "diffsac/estimators/learned_model.h"

namespace diffsac {

/// A network of a learned method with the features it reads: what training changes, checkpoints keep and rows use.
/// Each method's own struct adds its typed network and its options.
struct LearnedNetwork : LearnedModel {
  std::shared_ptr<torch::nn::Module> module;  ///< Set by the method's own constructor.
  torch::Device device = torch::kCPU;

  void MoveTo(const torch::Device& target);
  /// Before each call for inference: on a CPU this thread's operations of LibTorch keep to it from here on
  /// (problems_a_call). What else the thread does then sets its number of threads again.
  void BeginCall() const;

 protected:
  using LearnedModel::LearnedModel;
};

/// Gives a network that was made as `trained` says its averaged weights, ready for inference on `device`. Throws Error
/// naming the file and the first weight that differs.
void LoadWeights(const TrainedConfig& trained, const torch::Device& device, LearnedNetwork* network);

/// "auto" (CUDA where LibTorch has it and a device is there), "cpu", "cuda" or "cuda:1"; also other devices by their
/// names in LibTorch, as far as somebody has registered them with it. Throws Error for any other text, and for a device
/// that is not there.
torch::Device DeviceFromString(const std::string& name);

}  // namespace diffsac
