#include "diffsac/estimators/learned_model.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>

#include "diffsac/core/safetensors_header.h"
#include "diffsac/core/status.h"
#include "diffsac/network/engine/checkpoint_info.h"
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

std::int64_t CountOf(const Config& config, const char* key) {
  if (!config.Has(key)) return 0;
  const std::string text = config.Text(key);
  std::int64_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc() || end != text.data() + text.size() || count < 0)
    throw Error(config.Where(key) + ": expected a whole number");
  return count;
}

TrainingFacts FactsOf(const CheckpointInfo& info, const Config& config) {
  const Config train = config.Sub("train");
  const std::int64_t batch = CountOf(train, "batch_size");
  TrainingFacts facts;
  facts.samples = Product(info.iteration, batch);
  facts.run_samples = Product(CountOf(train, "iterations"), batch);
  if (train.Has("start_from")) facts.start = NetworkName(train.Text("start_from"));
  return facts;
}

Task TaskOf(const CheckpointInfo& info, const std::string& checkpoint) {
  const auto names = TaskNames();
  if (std::find(names.begin(), names.end(), info.task) == names.end())
    throw Error(checkpoint + ": trained for a task that is not known: " + Shown(info.task));
  return TaskFromString(info.task);
}

std::string TextOr(const Config& config, const char* key, const char* absent) {
  return config.Has(key) ? config.Text(key) : absent;
}

}  // namespace

TrainedConfig ReadTrainedConfig(const std::string& checkpoint) {
  const auto info = ReadCheckpointInfo(checkpoint);
  const auto config = CheckpointConfig(info, checkpoint);
  return {checkpoint, info.method,          TaskOf(info, checkpoint), config, TextOr(config, "model", ""),
          info.seed,  FactsOf(info, config)};
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
