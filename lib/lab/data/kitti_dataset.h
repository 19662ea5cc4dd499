#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lab/data/pair_dataset.h"

namespace diffsac {

/// KITTI odometry as `diffsac_prepare pairs --format kitti` writes it: scenes kitti_<sequence>_step_<step> below root,
/// in the order of their names.
struct KittiOptions {
  std::string root;
  std::vector<std::string> sequences = {"00", "01", "02", "03", "04", "05", "06", "07"};  ///< Empty: all.
  std::vector<int> steps;                                                                 ///< Empty: all.
  PairsOptions pairs;  ///< Its keys stand beside the others; the ratio's is `snn_threshold`.
  void Bind(OptionsBinder& b);
};

/// As MakePairDataset.
std::unique_ptr<Dataset> MakeKitti(const KittiOptions& options, std::uint64_t seed);

}  // namespace diffsac
