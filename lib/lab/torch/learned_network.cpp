#include "lab/torch/learned_network.h"

#include <torch/torch.h>

#include "diffsac/core/status.h"
#include "lab/torch/checkpoint.h"
#include "lab/torch/denoiser.h"

namespace diffsac {

// More would leave threads idle at the end of a batch, fewer would pay for each call more often.
constexpr int kProblemsOfCall = 4;

int ProblemsOfCall(const torch::Device& device) { return device.is_cpu() ? kProblemsOfCall : 0; }

void BeginCall(const LearnedModel& model) {
  if (model.problems_a_call > 0 && at::get_num_threads() != 1) at::set_num_threads(1);
}

void LoadForInference(const TrainedConfig& trained, torch::nn::Module* module, LearnedModel* model) {
  LoadAverage(trained.checkpoint, *module);
  module->eval();
  model->facts = trained.facts;
  model->facts.parameters = CountParameters(*module);
}

namespace {

constexpr const char* kExpected = "expected auto, cpu, cuda or cuda:INDEX";

// How many devices of a type there are. Never throws: a driver that fails is no device.
int CountDevices(torch::DeviceType type) {
  return c10::impl::hasDeviceGuardImpl(type) ? c10::impl::getDeviceGuardImpl(type)->deviceCount() : 0;
}

// Of a type that LibTorch knows, whether there is one or not.
torch::Device ParseDevice(const std::string& name) {
  try {
    const torch::Device device(name);
    // An index that wraps around reads as another one; "meta" has no values, and "cpu:0" is "cpu".
    if (device.str() == name && !device.is_meta() && !device.is_cpu()) return device;
  } catch (const c10::Error&) {
  }
  throw Error("device '" + name + "': " + kExpected);
}

}  // namespace

torch::Device DeviceFromString(const std::string& name) {
  if (name == "cpu") return torch::kCPU;
  if (name == "auto") return CountDevices(torch::kCUDA) > 0 ? torch::kCUDA : torch::kCPU;
  const torch::Device device = ParseDevice(name);
  const int count = CountDevices(device.type());
  if (count == 0 && device.is_cuda())
    throw Error("device '" + name +
                "': this LibTorch sees no CUDA device (build with -DDIFFSAC_CUDA=ON and a CUDA LibTorch)");
  if (count == 0) throw Error("device '" + name + "': this LibTorch sees none of this type; " + kExpected);
  if (device.index() >= count)
    throw Error("device '" + name + "': there are " + std::to_string(count) + ", the first has index 0");
  return device;
}

}  // namespace diffsac
