#include "diffsac/networks/learned_network.h"

#include <torch/torch.h>

#include "diffsac/core/status.h"
#include "diffsac/denoiser/checkpoint.h"
#include "diffsac/denoiser/denoiser.h"

namespace diffsac {

void LearnedNetwork::MoveTo(const torch::Device& target) {
  module->to(target);
  device = target;
}

void LoadWeights(const TrainedConfig& trained, const torch::Device& device, LearnedNetwork* network) {
  LoadAverage(trained.checkpoint, *network->module);
  network->module->eval();
  network->facts = trained.facts;
  network->facts.parameters = CountParameters(*network->module);
  network->MoveTo(device);
}

torch::Device DeviceFromString(const std::string& name) {
  if (name == "cpu") return torch::kCPU;
  if (name.starts_with("cuda:") && torch::cuda::is_available()) return torch::Device(name);
  if (name != "auto" && name != "cuda") throw Error("device '" + name + "': expected auto, cpu or cuda");
  if (torch::cuda::is_available()) return torch::kCUDA;
  if (name == "cuda")
    throw Error("device 'cuda': this LibTorch sees no CUDA device (build with -DDIFFSAC_CUDA=ON and a CUDA LibTorch)");
  return torch::kCPU;
}

}  // namespace diffsac
