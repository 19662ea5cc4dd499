#include "lab/config/dataset_factory.h"

#include <utility>

#include "lab/config/dataset_registry.h"
#include "lab/config/paths.h"

namespace diffsac {
namespace {

constexpr char kTypeKey[] = "type";

const DatasetEntry& EntryOf(const Config& config) {
  const auto& registry = Registry<DatasetEntry>::Instance();
  if (!config.Has(kTypeKey)) throw Error(config.Where(kTypeKey) + ": missing; expected one of " + registry.NamesText());
  return registry.Find(config.Text(kTypeKey), config.Where(kTypeKey));
}

/// Generated problems with their digests.
class DrawnDataset : public Dataset {
 public:
  explicit DrawnDataset(std::unique_ptr<Dataset> drawn) : drawn_(std::move(drawn)) {}
  Task task() const override { return drawn_->task(); }
  std::int64_t size() const override { return drawn_->size(); }
  std::string FolderOf(const std::string& scene) const override { return drawn_->FolderOf(scene); }
  Example Get(std::uint64_t index) const override {
    Example example = drawn_->Get(index);
    example.digest = PointDigest(example.problem.points);
    return example;
  }

 private:
  std::unique_ptr<Dataset> drawn_;
};

}  // namespace

std::unique_ptr<Dataset> MakeDataset(const Config& config, std::uint64_t seed) {
  const DatasetEntry& entry = EntryOf(config);
  const Config found = WithFoundPaths(config);
  entry.resolve(found);  // Mistakes in options come before files that are not there.
  RequirePaths(config, {"paths", "root"}, "file or folder");
  std::unique_ptr<Dataset> dataset = entry.make(found, seed);
  if (entry.generated) return std::make_unique<DrawnDataset>(std::move(dataset));
  return dataset;
}

std::string WriteDatasetOptions(const Config& config) { return EntryOf(config).resolve(WithFoundPaths(config)); }

bool IsGenerated(const Config& config) { return EntryOf(config).generated; }

}  // namespace diffsac
