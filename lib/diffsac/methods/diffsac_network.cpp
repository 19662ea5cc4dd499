#include "diffsac/methods/diffsac_network.h"

#include <torch/torch.h>

#include "diffsac/core/status.h"
#include "diffsac/denoiser/checkpoint.h"
#include "diffsac/diffusion/losses.h"
#include "diffsac/methods/trained_config.h"

namespace diffsac {

void NetworkOptions::Bind(OptionsBinder& b) {
  b.Group("features", features);
  b.Group("denoiser", denoiser);
  b.Group("schedule", schedule);
  b.Choice("loss", loss, {"mse", "bce"});
  b.Field("direct", direct);
  b.Require(!direct || !denoiser.self_conditioning, "direct", "false with denoiser.self_conditioning");
}

DiffsacNetwork::DiffsacNetwork(Task task_value, const NetworkOptions& network_options, Rng rng)
    : task(task_value),
      options(network_options),
      features(network_options.features, task_value),
      schedule(network_options.schedule),
      denoiser(MakeDenoiser(network_options.denoiser, features.width(), rng)) {}

void DiffsacNetwork::MoveTo(const torch::Device& target) {
  denoiser->to(target);
  device = target;
}

torch::Tensor DiffsacNetwork::Confidence(const torch::Tensor& output) const {
  return options.loss == "bce" ? LogitsToConfidence(output) : output;
}

std::shared_ptr<DiffsacNetwork> LoadNetwork(const std::string& checkpoint, Task task, const torch::Device& device) {
  const auto trained = ReadTrainedConfig(checkpoint, "diffsac", task);
  auto network = std::make_shared<DiffsacNetwork>(task, ReadOptions<NetworkOptions>(trained.config.Sub("network")),
                                                  Rng(trained.seed));
  LoadAverage(checkpoint, *network->denoiser);
  network->denoiser->eval();
  network->facts = trained.facts;
  network->facts.parameters = CountParameters(*network->denoiser);
  network->MoveTo(device);
  return network;
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
