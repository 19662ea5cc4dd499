#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "diffsac/core/enum_names.h"
#include "diffsac/core/registry.h"
#include "diffsac/estimate/learned_model.h"
#include "diffsac/guidance/diffusion/noise_schedule.h"
#include "diffsac/guidance/diffusion/reverse_sampler.h"
#include "diffsac/guidance/engine/network_options.h"

namespace diffsac {

/// What the reverse process is asked for.
struct DenoisingOptions {
  ReverseSamplerOptions sampler;
  int num_diffusion_samples = 20;  ///< κ; 0: no reverse process, the inlier head alone
  int max_decoded_points = 0;      ///< decode only so many of the likeliest points; 0: all
  bool keep_steps = false;
};

/// What a network says of one problem of N points. Confidences are κ rows of N values, −∞ for points that were not
/// decoded.
struct Denoised {
  std::vector<float> weights;             ///< N inlier probabilities; empty without the inlier head.
  std::vector<float> confidences;         ///< ĉ_0; empty for no copies.
  std::vector<std::vector<float>> steps;  ///< The prediction of each network call, in their order, where they are kept.
  std::vector<double> times;              ///< Diffusion times of these.
};

/// A trained denoiser, whatever computes it: DiffsacNetwork (lab/torch, LibTorch) or FusedDiffsac (plain C++). Many
/// threads may call it.
struct DiffsacModel : LearnedModel {
  NetworkOptions options;
  NoiseSchedule schedule;  ///< Of the options.

  DiffsacModel(Task task_value, const NetworkOptions& network_options)
      : LearnedModel(task_value, network_options.features),
        options(network_options),
        schedule(network_options.schedule) {}
  virtual ~DiffsacModel() = default;
  /// sets: the features of any number of problems; a problem's noise depends on its own seed alone. threads: of those
  /// that it makes itself (LibTorch uses its own).
  virtual std::vector<Denoised> Run(const DenoisingOptions& denoising, std::span<const FeatureSet* const> sets,
                                    std::span<const std::uint64_t> seeds, int threads) const = 0;
};

/// What computes a network.
///   kAuto      "auto": `fused` on the CPU for the architectures that it has, else `libtorch`
///   kFused     "fused": plain C++ (guidance/engine/cpu_denoiser.h), one problem a thread
///   kLibTorch  "libtorch": any architecture, any device, batches
enum class NetworkEngine { kAuto, kFused, kLibTorch };
template <>
inline constexpr auto kEnumNames<NetworkEngine> = NamesOf<NetworkEngine>({{NetworkEngine::kAuto, "auto"},
                                                                          {NetworkEngine::kFused, "fused"},
                                                                          {NetworkEngine::kLibTorch, "libtorch"}});

/// A framework that computes networks; registered where a program is linked with it (lab/torch).
struct DiffsacEngine {
  static constexpr const char* kKind = "network engine";
  std::function<bool(const std::string& device)> on_cpu;  ///< Throws Error for a device that is not there.
  std::function<std::shared_ptr<const DiffsacModel>(const TrainedConfig&, const std::string& device)> load;
};

/// Throws Error for a text that names no device, and for a device that is not there.
void CheckDevice(const std::string& device);

/// The network of a checkpoint, with its averaged weights. device: "auto", "cpu", "cuda" or "cuda:1". Throws Error
/// naming the file, or the row's key where the engine has not the architecture or the device.
std::shared_ptr<const DiffsacModel> LoadDiffsac(const TrainedConfig& trained, NetworkEngine engine,
                                                const std::string& device);

/// That network by `fused`, for architectures that CpuDenoiser has (fused_diffsac.cpp).
std::shared_ptr<const DiffsacModel> LoadFusedDiffsac(const TrainedConfig& trained, const NetworkOptions& options);

}  // namespace diffsac
