#include "diffsac/estimate/diffsac_model.h"

#include "diffsac/core/status.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "diffsac/guidance/engine/cpu_denoiser.h"

namespace diffsac {
namespace {

const DiffsacEngine* LibTorch() {
  const auto& engines = Registry<DiffsacEngine>::Instance();
  return engines.Has("libtorch") ? &engines.Find("libtorch", "") : nullptr;
}

bool OnCpu(const std::string& device) {
  if (const DiffsacEngine* libtorch = LibTorch()) return libtorch->on_cpu(device);
  if (device != "cpu" && device != "auto")
    throw Error("device '" + device + "': this program is built without LibTorch; expected auto or cpu");
  return true;
}

}  // namespace

void CheckDevice(const std::string& device) { OnCpu(device); }

std::shared_ptr<const DiffsacModel> LoadDiffsac(const TrainedConfig& trained, NetworkEngine engine,
                                                const std::string& device) {
  const bool on_cpu = OnCpu(device);
  const NetworkOptions options = ReadNetworkOptions(GroupOf(trained, "network"));
  // A block holds a matrix of its width at least.
  RequireWeights(trained.checkpoint, std::int64_t{options.denoiser.encoder_layers + options.denoiser.layers} *
                                         options.denoiser.width * options.denoiser.width);
  const std::string missing = CpuDenoiser::Missing(options);
  if (engine == NetworkEngine::kFused && (!on_cpu || !missing.empty()))
    throw Error(trained.checkpoint + ": engine 'fused' " + (on_cpu ? "has no " + missing : "runs on the CPU alone"));
  if (on_cpu && missing.empty() && engine != NetworkEngine::kLibTorch) return LoadFusedDiffsac(trained, options);
  if (const DiffsacEngine* libtorch = LibTorch()) return libtorch->load(trained, device);
  throw Error(trained.checkpoint + ": needs LibTorch, which this program is built without" +
              (missing.empty() ? " (engine 'libtorch')" : ": the fused network has no " + missing));
}

}  // namespace diffsac
