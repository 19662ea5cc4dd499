#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// Builds a dataset from YAML. The key `type` chooses it (lab/config/dataset_registry.h; docs/configuration.md lists
/// them), the other keys are its options. `seed` decides generated data. Throws Error: file, line, nearest valid key or
/// type.
std::unique_ptr<Dataset> MakeDataset(const Config& config, std::uint64_t seed);

/// The resolved options, `type` included, as YAML. Throws as MakeDataset does.
std::string WriteDatasetOptions(const Config& config);

/// Whether the data is drawn from a seed, with the keys `split` and `outlier_ratio`, and not read from files. Throws as
/// MakeDataset does.
bool IsGenerated(const Config& config);

}  // namespace diffsac
