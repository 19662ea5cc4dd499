#include "diffsac/guidance/engine/checkpoint_info.h"

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "diffsac/core/embedded_models.h"
#include "diffsac/core/registry.h"
#include "diffsac/core/safetensors.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr const char* kFormat = "diffsac-checkpoint";
constexpr const char* kVersion = "2";
constexpr const char* kOptimizer = "optimizer.";
constexpr const char* kLossSums = "loss_sums";

template <class T>
T NumberOf(const std::string& text, const SafetensorsFile& file, const char* key) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw Error(file.path() + ": its " + key + " " + Shown(text) + ": expected a number");
  return value;
}

template <class T>
T Number(const SafetensorsFile& file, const char* key) {
  return NumberOf<T>(file.Text(key), file, key);
}

// "3 0.5 0.25": steps, then the sums.
LossSums ReadLossSums(const SafetensorsFile& file) {
  LossSums losses;
  if (!file.HasText(kLossSums)) return losses;
  std::istringstream text(file.Text(kLossSums));
  std::string word;
  text >> word;
  losses.steps = NumberOf<std::int64_t>(word, file, kLossSums);
  while (text >> word) losses.sums.push_back(NumberOf<double>(word, file, kLossSums));
  if (losses.steps < 0) throw Error(file.path() + ": its " + kLossSums + " have a negative number of steps");
  return losses;
}

std::string TextOf(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string TextOf(const LossSums& losses) {
  std::string text = std::to_string(losses.steps);
  for (const double sum : losses.sums) text += " " + TextOf(sum);
  return text;
}

}  // namespace

SafetensorsFile OpenCheckpoint(const std::string& path) {
  const std::string_view embedded = EmbeddedModel(path);
  if (embedded.empty() && !std::filesystem::exists(path)) throw Error(path + ": no such checkpoint");
  SafetensorsFile file = embedded.empty() ? SafetensorsFile(path) : SafetensorsFile(path, embedded);
  if (!file.HasText("format") || file.Text("format") != kFormat) throw Error(path + ": not a DiffSAC checkpoint");
  if (file.Text("version") != kVersion)
    throw Error(path + ": checkpoint version " + Shown(file.Text("version")) + ", this program reads version '" +
                kVersion + "'");
  for (const auto& [name, tensor] : file.tensors())
    if (!name.starts_with(kNetworkTensors) && !name.starts_with(kAverageTensors) && !name.starts_with(kOptimizer))
      throw Error(path + ": tensor " + Shown(name) + ": expected a name with network., average. or optimizer.");
  return file;
}

std::int64_t ReadCount(const SafetensorsFile& file, const char* key) {
  const auto count = Number<std::int64_t>(file, key);
  if (count < 0) throw Error(file.path() + ": its " + key + " is negative");
  return count;
}

CheckpointInfo ReadInfo(const SafetensorsFile& file) {
  CheckpointInfo info;
  info.method = file.Text("method");
  info.task = file.Text("task");
  info.config = file.Text("config");
  info.git_revision = file.Text("git_revision");
  info.iteration = ReadCount(file, "iteration");
  info.seed = Number<std::uint64_t>(file, "seed");
  info.best_validation = Number<double>(file, "best_validation");
  info.losses = ReadLossSums(file);
  return info;
}

CheckpointInfo ReadCheckpointInfo(const std::string& path) { return ReadInfo(OpenCheckpoint(path)); }

std::string ConfigName(const std::string& checkpoint) { return checkpoint + " (its configuration)"; }

std::string ConfigText(const CheckpointInfo& info, const std::string& path) {
  if (info.config.starts_with('{')) return info.config;
  const auto& readers = Registry<CheckpointConfigReader>::Instance();
  if (readers.Has("yaml")) return readers.Find("yaml", "").to_json(info.config, ConfigName(path));
  throw Error(ConfigName(path) + ": expected JSON; files of earlier versions hold YAML, which diffsac_eval reads");
}

void RequireWeights(const std::string& path, std::int64_t least) {
  const SafetensorsFile file = OpenCheckpoint(path);
  std::int64_t weights = 0;
  for (const auto& [name, tensor] : file.tensors())
    if (name.starts_with(kAverageTensors))
      weights += static_cast<std::int64_t>((tensor.end - tensor.begin) / sizeof(float));
  if (weights < least)
    throw Error(path + ": its configuration asks for a network of at least " + std::to_string(least) +
                " weights, it holds " + std::to_string(weights));
}

void WriteInfo(const CheckpointInfo& info, SafetensorsWriter* writer) {
  writer->AddText("format", kFormat);
  writer->AddText("version", kVersion);
  writer->AddText("method", info.method);
  writer->AddText("task", info.task);
  writer->AddText("config", info.config);
  writer->AddText("git_revision", info.git_revision);
  writer->AddText("iteration", std::to_string(info.iteration));
  writer->AddText("seed", std::to_string(info.seed));
  writer->AddText("best_validation", TextOf(info.best_validation));
}

void WriteLossSums(const LossSums& losses, SafetensorsWriter* writer) { writer->AddText(kLossSums, TextOf(losses)); }

}  // namespace diffsac
