#pragma once

#include <torch/nn/module.h>

#include <memory>
#include <string>

#include "diffsac/estimate/learned_model.h"

namespace diffsac {

/// LearnedModel::problems_a_call of networks on a device.
int ProblemsOfCall(const torch::Device& device);

/// Before each call for inference: on a CPU this thread's operations of LibTorch keep to it from here on
/// (problems_a_call). What else the thread does then sets its number of threads again.
void BeginCall(const LearnedModel& model);

/// LearnedNetwork::Load, but for the device.
void LoadForInference(const TrainedConfig& trained, torch::nn::Module* module, LearnedModel* model);

/// A model whose network LibTorch computes: what training changes, checkpoints keep and rows use. Model: LearnedModel,
/// or what adds a method's own to it; Module: the network's type.
template <class Model, class Module>
struct LearnedNetwork : Model {
  std::shared_ptr<Module> module;
  torch::Device device = torch::kCPU;

  using Model::Model;
  void MoveTo(const torch::Device& target) {
    module->to(target);
    device = target;
    this->problems_a_call = ProblemsOfCall(target);
  }
  /// A network that was made as `trained` says gets its averaged weights, ready for inference on `target`. Throws Error
  /// naming the file and the first weight that differs.
  void Load(const TrainedConfig& trained, const torch::Device& target) {
    LoadForInference(trained, module.get(), this);
    MoveTo(target);
  }
};

/// "auto" (CUDA where LibTorch has it and a device is there), "cpu", "cuda" or "cuda:1"; also other devices by their
/// names in LibTorch, as far as somebody has registered them with it. Throws Error for any other text, and for a device
/// that is not there.
torch::Device DeviceFromString(const std::string& name);

}  // namespace diffsac
