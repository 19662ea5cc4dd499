#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/registry.h"
#include "lab/config/yaml.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// A type of data. It is registered at the end of the file that reads or makes it:
/// ```
/// const RegisteredDataset<KittiOptions> kKitti("kitti", DataSource::kFiles, "KITTI odometry ...", MakeKitti);
/// ```
struct DatasetEntry {
  static constexpr const char* kKind = "type of data";
  std::string help;        ///< One line for the documentation.
  bool generated = false;  ///< Drawn anew from a seed, with the keys `split` and `outlier_ratio`.
  std::function<std::unique_ptr<Dataset>(const Config& config, std::uint64_t seed)> make;
  std::function<std::string(const Config& config)> resolve;  ///< The options as YAML, `type` included.
  std::function<std::vector<OptionDescription>()> describe;
};

enum class DataSource { kFiles, kGenerated };

/// Options: a struct with `Bind`. make: called with the options and the run's seed.
template <class Options>
struct RegisteredDataset : Registered<DatasetEntry> {
  using Make = std::function<std::unique_ptr<Dataset>(const Options&, std::uint64_t)>;
  RegisteredDataset(const std::string& type, DataSource source, const std::string& help, Make make)
      : Registered<DatasetEntry>(type, EntryOf(type, source, help, std::move(make))) {}

 private:
  static DatasetEntry EntryOf(const std::string& type, DataSource source, const std::string& help, Make make) {
    const auto read = [type](const Config& config) { return ReadOptions(config, TypedOptions<Options>{type, {}}); };
    DatasetEntry entry;
    entry.help = help;
    entry.generated = source == DataSource::kGenerated;
    entry.make = [read, make = std::move(make)](const Config& config, std::uint64_t seed) {
      return make(read(config).options, seed);
    };
    entry.resolve = [read](const Config& config) { return WriteYaml(read(config)); };
    entry.describe = [] { return DescribeOptions<Options>(); };
    return entry;
  }
};

}  // namespace diffsac
