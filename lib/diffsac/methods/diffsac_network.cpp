#include "diffsac/methods/diffsac_network.h"

#include <torch/torch.h>

#include "diffsac/diffusion/losses.h"

namespace diffsac {

void NetworkOptions::Bind(OptionsBinder& b) {
  b.Field("features", features).Help("what the network sees of a point");
  b.Field("denoiser", denoiser).Help("the network's layers");
  b.Field("schedule", schedule).Help("the forward process");
  b.Field("loss", loss)
      .Help("`mse`: the network's output is ĉ_0 (Algorithm 1); `bce`: it is the logit of \"c_0 = +1\"");
  b.Field("direct", direct)
      .Help("no diffusion: trained without noise to predict c_0 from the points at once, and called once");
  b.Require(!direct || !denoiser.self_conditioning, "direct", "false with denoiser.self_conditioning");
}

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

}  // namespace diffsac
