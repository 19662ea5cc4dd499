#include "diffsac/estimate/learned_model.h"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "diffsac/core/safetensors_header.h"
#include "diffsac/core/status.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

// NAME of models/NAME/model.safetensors and runs/NAME/checkpoints/best.safetensors.
std::string NetworkName(const std::string& checkpoint) {
  auto folder = std::filesystem::path(checkpoint).parent_path();
  if (folder.filename() == "checkpoints") folder = folder.parent_path();
  return folder.filename().string();
}

// A file may say what overflows.
std::int64_t Product(std::int64_t a, std::int64_t b) {
  std::int64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? std::numeric_limits<std::int64_t>::max() : product;
}

std::int64_t CountOf(const StoredOptions& stored, const char* key) {
  std::int64_t count = 0;
  stored.Read(key, &count, 0, 9e18);
  return count;
}

TrainingFacts FactsOf(const CheckpointInfo& info, const StoredOptions& train) {
  const std::int64_t batch = CountOf(train, "batch_size");
  TrainingFacts facts;
  facts.samples = Product(info.iteration, batch);
  facts.run_samples = Product(CountOf(train, "iterations"), batch);
  std::string start;
  train.Read("start_from", &start);
  if (!start.empty()) facts.start = NetworkName(start);
  return facts;
}

Task TaskOf(const CheckpointInfo& info, const std::string& checkpoint) {
  const auto names = TaskNames();
  if (std::find(names.begin(), names.end(), info.task) == names.end())
    throw Error(checkpoint + ": trained for a task that is not known: " + Shown(info.task));
  return TaskFromString(info.task);
}

}  // namespace

TrainedConfig ReadTrainedConfig(const std::string& checkpoint) {
  const auto info = ReadCheckpointInfo(checkpoint);
  const std::string text = ConfigText(info, checkpoint);
  const StoredOptions config(text, ConfigName(checkpoint));
  std::string model;
  config.Read("model", &model);
  return {checkpoint, info.method, TaskOf(info, checkpoint),          text,
          model,      info.seed,   FactsOf(info, config.Sub("train"))};
}

StoredOptions GroupOf(const TrainedConfig& trained, const char* key) {
  return StoredOptions(trained.config, ConfigName(trained.checkpoint)).Sub(key);
}

void CheckTrainedFor(const TrainedConfig& trained, const std::string& method, Task task) {
  if (trained.method != method)
    throw Error(trained.checkpoint + ": trained by method " + Shown(trained.method) + ", this row needs '" + method +
                "'");
  if (trained.task != task)
    throw Error(trained.checkpoint + ": trained for task '" + ToString(trained.task) + "', this experiment needs '" +
                ToString(task) + "'");
}

TrainedConfig ReadTrainedConfig(const std::string& checkpoint, const std::string& method, Task task) {
  TrainedConfig trained = ReadTrainedConfig(checkpoint);
  CheckTrainedFor(trained, method, task);
  return trained;
}

}  // namespace diffsac
