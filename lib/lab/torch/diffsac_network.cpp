#include "lab/torch/diffsac_network.h"

#include <torch/torch.h>

#include "diffsac/estimators/diffsac_model.h"
#include "lab/torch/losses.h"

namespace diffsac {

DiffsacNetwork::DiffsacNetwork(Task task_value, const NetworkOptions& network_options, Rng rng)
    : LearnedNetwork(task_value, network_options.features),
      options(network_options),
      schedule(network_options.schedule),
      denoiser(MakeDenoiser(network_options.denoiser, {features.width(), features.first_preference()}, rng)) {
  module = denoiser;
}

torch::Tensor DiffsacNetwork::Confidence(const torch::Tensor& output) const {
  return options.loss == DiffusionLossKind::kBce ? LogitsToConfidence(output) : output;
}

std::shared_ptr<DiffsacNetwork> LoadNetwork(const TrainedConfig& trained, const torch::Device& device) {
  const auto options = ReadStoredOptions<NetworkOptions>(trained.config.Sub("network"));
  auto network = std::make_shared<DiffsacNetwork>(trained.task, options, Rng(trained.seed));
  LoadWeights(trained, device, network.get());
  return network;
}

namespace {

const Registered<DiffsacEngine> kLibTorch("libtorch",
                                          {[](const std::string& device) { return DeviceFromString(device).is_cpu(); },
                                           [](const TrainedConfig& trained,
                                              const std::string& device) -> std::shared_ptr<const DiffsacModel> {
                                             return LoadNetwork(trained, DeviceFromString(device));
                                           }});

}  // namespace

}  // namespace diffsac
