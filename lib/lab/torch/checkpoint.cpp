#include "lab/torch/checkpoint.h"

#include <torch/torch.h>

#include "diffsac/core/safetensors.h"
#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/torch/network_tensors.h"

namespace diffsac {
namespace {

constexpr const char* kOptimizer = "optimizer.";

bool HasPart(const SafetensorsFile& file, const char* prefix) {
  const auto first = file.tensors().lower_bound(prefix);
  return first != file.tensors().end() && first->first.starts_with(prefix);
}

}  // namespace

void SaveCheckpoint(const std::string& path, const CheckpointInfo& info, const torch::nn::Module& network,
                    const ExponentialMovingAverage& average, const torch::optim::Adam* optimizer) {
  SafetensorsWriter writer;
  WriteInfo(info, &writer);
  writer.AddText("average_updates", std::to_string(average.updates()));
  AddTensors(kAverageTensors, network, average.shadow(), &writer);
  if (optimizer != nullptr) {
    WriteLossSums(info.losses, &writer);
    AddTensors(kNetworkTensors, network, network.parameters(), &writer);
    AddOptimizer(network, *optimizer, &writer);
  }
  WriteFileAtomically(path, writer.Content());
}

CheckpointInfo LoadCheckpoint(const std::string& path, torch::nn::Module& network, ExponentialMovingAverage* average,
                              torch::optim::Adam* optimizer) {
  SafetensorsFile file = OpenCheckpoint(path);
  const auto info = ReadInfo(file);
  if (!HasPart(file, kOptimizer)) throw Error(path + ": holds no optimiser state; training cannot resume");
  ReadTensors(kNetworkTensors, network, network.parameters(), &file);
  ReadTensors(kAverageTensors, network, average->shadow(), &file);
  average->set_updates(ReadCount(file, "average_updates"));
  ReadOptimizer(network, optimizer, &file);
  return info;
}

CheckpointInfo LoadAverage(const std::string& path, torch::nn::Module& network) {
  SafetensorsFile file = OpenCheckpoint(path);
  const auto info = ReadInfo(file);
  ReadTensors(kAverageTensors, network, network.parameters(), &file);
  return info;
}

}  // namespace diffsac
