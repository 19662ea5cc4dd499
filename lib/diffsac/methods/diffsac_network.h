#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "diffsac/data/point_features.h"
#include "diffsac/denoiser/denoiser.h"
#include "diffsac/diffusion/noise_schedule.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// Everything that must be the same in training and in inference.
struct NetworkOptions {
  PointFeaturesOptions features;
  DenoiserOptions denoiser;
  NoiseScheduleOptions schedule;
  /// No diffusion: the network is trained without noise (c_t = 0, t = T − 1) to predict c_0 from the points at once, and is
  /// called once; samplers are not used. The paper's ablation (a), "direct learning confidence".
  bool direct = false;
  std::string loss = "bce";   ///< "mse": the network's output is ĉ_0 (Algorithm 1); "bce": it is the logit of "c_0 = +1"
  void Bind(OptionsBinder& b);
};

/// A network with the features it reads and the schedule it was trained for.
struct DiffsacNetwork {
  Task task;
  NetworkOptions options;
  PointFeatures features;
  NoiseSchedule schedule;
  std::shared_ptr<Denoiser> denoiser;
  torch::Device device = torch::kCPU;
  TrainingFacts facts;  ///< Of a loaded network.

  DiffsacNetwork(Task task, const NetworkOptions& options, Rng rng);
  void MoveTo(const torch::Device& device);
  /// ĉ_0 in about [−1, 1] from the network's raw output.
  torch::Tensor Confidence(const torch::Tensor& output) const;
};

/// Reads task, options and averaged weights from a checkpoint. Throws Error naming the file; also when the checkpoint was
/// trained for another task.
std::shared_ptr<DiffsacNetwork> LoadNetwork(const std::string& checkpoint, Task task, const torch::Device& device);

/// "auto" (CUDA where LibTorch has it and a device is there), "cpu", "cuda" or "cuda:1". Throws Error when CUDA is asked for in vain.
torch::Device DeviceFromString(const std::string& name);

}  // namespace diffsac
