#include "diffsac/data/dataset_factory.h"

#include "diffsac/core/resources.h"
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
  const DatasetEntry& entry = EntryOf(config);
  const Config found = WithFoundPaths(config);
  entry.resolve(found);  // Mistakes in options come before files that are not there.
  RequirePaths(config, {"paths", "root"}, "file or folder");
  return entry.make(found, seed);
}

std::string WriteDatasetOptions(const Config& config) { return EntryOf(config).resolve(WithFoundPaths(config)); }

bool IsGenerated(const Config& config) { return EntryOf(config).generated; }

}  // namespace diffsac
