#include "diffsac/data/dataset_factory.h"

#include "diffsac/data/dataset_registry.h"

namespace diffsac {
namespace {

constexpr char kTypeKey[] = "type";

const DatasetEntry& EntryOf(const Config& config) {
  const auto& registry = Registry<DatasetEntry>::Instance();
  if (!config.Has(kTypeKey)) throw Error(config.Where(kTypeKey) + ": missing; expected one of " + registry.NamesText());
  return registry.Find(config.Text(kTypeKey), config.Where(kTypeKey));
}

}  // namespace

std::unique_ptr<Dataset> MakeDataset(const Config& config, std::uint64_t seed) {
  return EntryOf(config).make(config, seed);
}

std::string WriteDatasetOptions(const Config& config) { return EntryOf(config).resolve(config); }

bool IsGenerated(const Config& config) { return EntryOf(config).generated; }

}  // namespace diffsac
