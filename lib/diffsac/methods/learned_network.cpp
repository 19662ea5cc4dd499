#include "diffsac/methods/learned_network.h"

#include <torch/torch.h>

#include <filesystem>

#include "diffsac/core/status.h"
#include "diffsac/data/tasks.h"
#include "diffsac/denoiser/checkpoint.h"
#include "diffsac/denoiser/denoiser.h"

namespace diffsac {
namespace {

// The one place that reads old keys. Until models had names, `labels.fundamental_points` and
// `inference.fundamental_points` said by 7 or 8 which minimal sets a fundamental matrix is solved from (for other tasks
// they said nothing): 8 is now `model: fundamental8`. The old keys themselves stay; readers of stored options pass over
// them.
void ReplaceOldKeys(Config* config) {
  const char* key = "inference.fundamental_points";
  const bool eight = config->Has(key) && config->Text(key) == "8" && config->Has("task") &&
                     config->Text("task") == kModelName<Fundamental>;
  if (eight && !config->Has("model")) config->Set(std::string("model=") + kModelName<Fundamental8>);
}

Config ConfigOf(const CheckpointInfo& info, const std::string& checkpoint) {
  Config config = Config::FromString(info.config, checkpoint + " (its configuration)");
  ReplaceOldKeys(&config);
  return config;
}

// NAME of models/NAME/model.pt and runs/NAME/checkpoints/best.pt.
std::string NetworkName(const std::string& checkpoint) {
  auto folder = std::filesystem::path(checkpoint).parent_path();
  if (folder.filename() == "checkpoints") folder = folder.parent_path();
  return folder.filename().string();
}

TrainingFacts FactsOf(const CheckpointInfo& info, const Config& config) {
  const Config train = config.Sub("train");
  const auto number = [&](const char* key) { return train.Has(key) ? std::stoll(train.Text(key)) : 0LL; };
  TrainingFacts facts;
  facts.samples = info.iteration * number("batch_size");
  facts.run_samples = number("iterations") * number("batch_size");
  if (train.Has("start_from")) facts.start = NetworkName(train.Text("start_from"));
  return facts;
}

std::string TextOr(const Config& config, const char* key, const char* absent) {
  return config.Has(key) ? config.Text(key) : absent;
}

}  // namespace

void LearnedNetwork::MoveTo(const torch::Device& target) {
  module->to(target);
  device = target;
}

TrainedConfig ReadTrainedConfig(const std::string& checkpoint) {
  const auto info = ReadCheckpointInfo(checkpoint);
  const auto config = ConfigOf(info, checkpoint);
  if (!config.Has("task")) throw Error(checkpoint + ": its configuration names no task");
  return {checkpoint,
          TextOr(config, "method", "diffsac"),
          TaskFromString(config.Text("task")),
          config,
          TextOr(config, "model", ""),
          info.seed,
          FactsOf(info, config)};
}

void CheckTrainedFor(const TrainedConfig& trained, const std::string& method, Task task) {
  if (trained.method != method)
    throw Error(trained.checkpoint + ": trained by method '" + trained.method + "', this row needs '" + method + "'");
  if (trained.task != task)
    throw Error(trained.checkpoint + ": trained for task '" + ToString(trained.task) + "', this experiment needs '" +
                ToString(task) + "'");
}

TrainedConfig ReadTrainedConfig(const std::string& checkpoint, const std::string& method, Task task) {
  TrainedConfig trained = ReadTrainedConfig(checkpoint);
  CheckTrainedFor(trained, method, task);
  return trained;
}

void LoadWeights(const TrainedConfig& trained, const torch::Device& device, LearnedNetwork* network) {
  LoadAverage(trained.checkpoint, *network->module);
  network->module->eval();
  network->facts = trained.facts;
  network->facts.parameters = CountParameters(*network->module);
  network->MoveTo(device);
}

torch::Device DeviceFromString(const std::string& name) {
  if (name == "cpu") return torch::kCPU;
  if (name.starts_with("cuda:") && torch::cuda::is_available()) return torch::Device(name);
  if (name != "auto" && name != "cuda") throw Error("device '" + name + "': expected auto, cpu or cuda");
  if (torch::cuda::is_available()) return torch::kCUDA;
  if (name == "cuda")
    throw Error("device 'cuda': this LibTorch sees no CUDA device (build with -DDIFFSAC_CUDA=ON and a CUDA LibTorch)");
  return torch::kCPU;
}

}  // namespace diffsac
