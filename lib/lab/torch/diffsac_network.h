#pragma once

#include <memory>
#include <string>

#include "diffsac/estimate/diffsac_model.h"
#include "lab/torch/denoiser.h"
#include "lab/torch/learned_network.h"
#include "lab/torch/losses.h"

namespace diffsac {

/// A denoiser with the schedule it was trained for, computed by LibTorch: for training, for GPUs and for architectures
/// that FusedDiffsac has not.
struct DiffsacNetwork : LearnedNetwork<DiffsacModel, Denoiser> {
  DiffsacNetwork(Task task, const NetworkOptions& options, Rng rng);
  /// ĉ_0 in about [−1, 1] from the network's raw output.
  torch::Tensor Confidence(const torch::Tensor& output) const;
  /// The paper's reverse process for a batch of problems at once, on the network's device.
  std::vector<Denoised> Run(const DenoisingOptions& denoising, std::span<const FeatureSet* const> sets,
                            std::span<const std::uint64_t> seeds, int threads) const override;
};

/// The network of a checkpoint that the method trained, with its averaged weights. Throws Error naming the file.
std::shared_ptr<DiffsacNetwork> LoadNetwork(const TrainedConfig& trained, const torch::Device& device);

}  // namespace diffsac
