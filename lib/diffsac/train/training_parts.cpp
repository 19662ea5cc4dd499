#include <cstdlib>
#include <sstream>

#include "diffsac/core/status.h"
#include "diffsac/core/yaml_tree.h"
#include "diffsac/data/dataset_factory.h"
#include "diffsac/train/training_source.h"

namespace diffsac {
namespace {

constexpr char kMixture[] = "mixture";

bool IsMixture(const Config& data) { return data.Has("type") && data.Text("type") == kMixture; }

struct PartConfig {
  Config data;
  double weight = 1.0;
};

// A part's own keys without the weight, which no dataset knows.
PartConfig ReadPart(const Config& config) {
  PartConfig part;
  if (config.Has("weight")) {
    const std::string text = config.Text("weight");
    char* end = nullptr;
    part.weight = std::strtod(text.c_str(), &end);
    if (*end != '\0' || !(part.weight > 0.0))
      throw Error(config.Where("weight") + ": expected a positive number, got '" + text + "'");
  }
  YamlTree tree = *config.impl_->Get();
  std::erase_if(tree.entries, [](const YamlEntry& entry) { return entry.key == "weight"; });
  part.data.impl_->document->root = std::move(tree);
  return part;
}

std::vector<PartConfig> ReadParts(const Config& data) {
  for (const auto& entry : data.impl_->Get()->entries)
    if (entry.key != "type" && entry.key != "parts")
      throw Error(data.Where(entry.key) + ": a mixture has the keys type and parts only");
  std::vector<PartConfig> parts;
  for (const Config& config : data.Sequence("parts")) parts.push_back(ReadPart(config));
  if (parts.empty()) throw Error(data.Where("parts") + ": expected a list of datasets, each with its type");
  return parts;
}

std::string Indented(const std::string& text, const std::string& first, const std::string& rest) {
  std::istringstream lines(text);
  std::string out, indent = first;
  for (std::string line; std::getline(lines, line); indent = rest) out += indent + line + "\n";
  return out;
}

}  // namespace

std::vector<TrainingPart> MakeTrainingParts(const Config& data, std::uint64_t seed) {
  std::vector<TrainingPart> parts;
  if (!IsMixture(data)) {
    parts.push_back({MakeDataset(data, seed), 1.0});
    return parts;
  }
  for (const PartConfig& part : ReadParts(data)) parts.push_back({MakeDataset(part.data, seed), part.weight});
  for (const TrainingPart& part : parts) {
    if (part.dataset->task() != parts.front().dataset->task())
      throw Error(data.Where("parts") + ": data of different tasks");
    if (part.dataset->size() == 0) throw Error(data.Where("parts") + ": a part holds no examples");
  }
  return parts;
}

std::string WriteTrainingData(const Config& data) {
  if (!IsMixture(data)) return WriteDatasetOptions(data);
  std::string text = std::string("type: ") + kMixture + "\nparts:\n";
  for (const PartConfig& part : ReadParts(data))
    text += "  - weight: " + DoubleText(part.weight) + "\n" + Indented(WriteDatasetOptions(part.data), "    ", "    ");
  return text;
}

}  // namespace diffsac
