#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lab/data/pair_dataset.h"

namespace diffsac {

/// Scenes anywhere; all pairs are read when the dataset is made and stay in memory.
struct CorrespondencesOptions {
  std::vector<std::string> paths;  ///< Folders of correspondence files, or folders of such folders; a scene each.
  PairsOptions pairs;              ///< Its keys stand beside the others; the ratio's is `max_ratio`.
  CorrespondencesOptions() { pairs.empty_pairs = EmptyPairs::kKeep; }
  void Bind(OptionsBinder& b);
};

/// As MakePairDataset.
std::unique_ptr<Dataset> MakeCorrespondences(const CorrespondencesOptions& options, std::uint64_t seed);

}  // namespace diffsac
