#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lab/data/pair_dataset.h"

namespace diffsac {

/// The CVPR 2020 RANSAC tutorial: <root>/<split>/<scene>, or, for its homographies, <root>/<scene>/<split> with root
/// homography/, or <root>/<split> with root homography/EVD.
struct RansacTutorialOptions {
  std::string root;
  std::string split = "val";        ///< Folder name: "train", "val", "test"; "validation" means "val".
  std::vector<std::string> scenes;  ///< Empty: all, in the order of their names; else these, in their order.
  PairsOptions pairs;               ///< Its keys stand beside the others; the ratio's is `snn_threshold`.
  void Bind(OptionsBinder& b);
};

/// As MakePairDataset.
std::unique_ptr<Dataset> MakeRansacTutorial(const RansacTutorialOptions& options, std::uint64_t seed);

}  // namespace diffsac
