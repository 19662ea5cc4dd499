#pragma once

#include <functional>
#include <memory>
#include <string>

#include "diffsac/core/options.h"
#include "diffsac/core/registry.h"
#include "diffsac/estimators/diffsac_model.h"

namespace diffsac {

/// What computes a network.
///   kAuto      "auto": `fused` on the CPU for the architectures that it has, else `libtorch`
///   kFused     "fused": plain C++ (network/engine/fused_denoiser.h), one problem a thread
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

}  // namespace diffsac
