#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "lab/images/run_pairs.h"

namespace diffsac {

/// The command `diffsac_prepare modelnet`: pairs of virtual views of meshes (lab/data/modelnet.h, which fixes all
/// that is not said here) as correspondence files with poses, calibration and labels.
struct ModelnetRequest {
  std::string input, output;  ///< A folder of OFF files at any depth; a folder for the scene's folder.
  std::string scene = "modelnet40";
  std::string subset;  ///< "train" or "test", the folder of ModelNet40's split; empty: all meshes.
  int pairs = 1000;
  std::vector<double> outlier_ratio = {0.1, 0.6};  ///< One value, or the ends of a range.
  int points = 200;                                ///< Correspondences a pair.
  int seed = 1;
  bool overwrite = false;
  int threads = 0;  ///< 0: all cores. The files do not depend on it.
};

/// Pair i shows mesh i mod (number of meshes); its images are named <i>_<mesh>_1 and _2. Meshes that cannot be read, or
/// of which no two views share enough points, are left out with a warning. Throws Error: no meshes, no pairs left.
PrepareResult WriteModelnetPairs(const ModelnetRequest& request, const std::atomic<bool>& stop);

}  // namespace diffsac
