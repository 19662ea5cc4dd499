#include "diffsac/methods/trained_config.h"

#include <filesystem>

#include "diffsac/core/status.h"
#include "diffsac/denoiser/checkpoint.h"

namespace diffsac {
namespace {

Config ConfigOf(const CheckpointInfo& info, const std::string& checkpoint) {
  return Config::FromString(info.config, checkpoint + " (its configuration)");
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

std::string MethodOf(const Config& config) { return config.Has("method") ? config.Text("method") : "diffsac"; }

}  // namespace

std::string TrainedMethod(const std::string& checkpoint) {
  return MethodOf(ConfigOf(ReadCheckpointInfo(checkpoint), checkpoint));
}

TrainedConfig ReadTrainedConfig(const std::string& checkpoint, const std::string& method, Task task) {
  const auto info = ReadCheckpointInfo(checkpoint);
  const auto config = ConfigOf(info, checkpoint);
  const std::string trained_method = MethodOf(config);
  const std::string trained_task = config.Has("task") ? config.Text("task") : "";
  if (trained_method != method)
    throw Error(checkpoint + ": trained by method '" + trained_method + "', this row needs '" + method + "'");
  if (TaskFromString(trained_task) != task)
    throw Error(checkpoint + ": trained for task '" + trained_task + "', this experiment needs '" + ToString(task) +
                "'");
  return {config, info.seed, FactsOf(info, config)};
}

}  // namespace diffsac
