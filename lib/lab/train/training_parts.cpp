#include "diffsac/core/status.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/options/options.h"
#include "lab/train/training_source.h"

namespace diffsac {
namespace {

constexpr char kMixture[] = "mixture";

bool IsMixture(const Config& data) { return data.Has("type") && data.Text("type") == kMixture; }

struct MixturePart {
  double weight = 1.0;
  Config data;
  void Bind(OptionsBinder& b) {
    b.Field("weight", weight, Positive()).Help("examples are drawn in proportion to it");
    b.Rest(data).Help("the keys of the part's own data, `type` among them");
  }
};

struct Mixture {
  std::string type = kMixture;
  std::vector<MixturePart> parts;
  void Bind(OptionsBinder& b) {
    b.Choice("type", type, {kMixture}).Help("several datasets");
    b.Field("parts", parts).Help("datasets of one task");
    b.Require(!parts.empty(), "parts", "a list of datasets, each with its type");
  }
};

}  // namespace

std::vector<TrainingPart> MakeTrainingParts(const Config& data, std::uint64_t seed) {
  std::vector<TrainingPart> parts;
  if (!IsMixture(data)) {
    parts.push_back({MakeDataset(data, seed), 1.0});
    return parts;
  }
  for (const MixturePart& part : ReadOptions<Mixture>(data).parts)
    parts.push_back({MakeDataset(part.data, seed), part.weight});
  for (const TrainingPart& part : parts) {
    if (part.dataset->task() != parts.front().dataset->task())
      throw Error(data.Where("parts") + ": data of different tasks");
    if (part.dataset->size() == 0) throw Error(data.Where("parts") + ": a part holds no examples");
  }
  return parts;
}

Config FirstTrainingPart(const Config& data) {
  return IsMixture(data) ? ReadOptions<Mixture>(data).parts.front().data : data;
}

std::vector<OptionDescription> DescribeMixture() { return DescribeOptions<Mixture>(); }

std::string WriteTrainingData(const Config& data) {
  if (!IsMixture(data)) return WriteDatasetOptions(data);
  Mixture mixture = ReadOptions<Mixture>(data);
  for (MixturePart& part : mixture.parts) part.data = ConfigFromYaml(WriteDatasetOptions(part.data));
  return WriteYaml(mixture);
}

}  // namespace diffsac
