#pragma once

#include <memory>
#include <string>

#include "diffsac/denoiser/denoiser.h"
#include "diffsac/diffusion/losses.h"
#include "diffsac/diffusion/noise_schedule.h"
#include "diffsac/methods/learned_network.h"

namespace diffsac {

/// Everything that must be the same in training and in inference.
struct NetworkOptions {
  PointFeaturesOptions features;
  DenoiserOptions denoiser;
  NoiseScheduleOptions schedule;
  /// No diffusion: the network is trained without noise (c_t = 0, t = T − 1) to predict c_0 from the points at once,
  /// and is called once; samplers are not used. The paper's ablation (a), "direct learning confidence".
  bool direct = false;
  DiffusionLossKind loss = DiffusionLossKind::kBce;  ///< What the network puts out.
  void Bind(OptionsBinder& b);
};

/// A denoiser with the schedule it was trained for.
struct DiffsacNetwork : LearnedNetwork {
  NetworkOptions options;
  NoiseSchedule schedule;
  std::shared_ptr<Denoiser> denoiser;

  DiffsacNetwork(Task task, const NetworkOptions& options, Rng rng);
  /// ĉ_0 in about [−1, 1] from the network's raw output.
  torch::Tensor Confidence(const torch::Tensor& output) const;
};

/// The network of a checkpoint that the method trained, with its averaged weights. Throws Error naming the file.
std::shared_ptr<DiffsacNetwork> LoadNetwork(const TrainedConfig& trained, const torch::Device& device);

}  // namespace diffsac
