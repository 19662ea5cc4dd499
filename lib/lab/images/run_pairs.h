#pragma once

#include <atomic>
#include <string>

#include "lab/images/prepare_pairs.h"

namespace diffsac {

/// The command `diffsac_prepare pairs`.
struct PairsRequest {
  std::string format;            ///< Of those registered (image_format.h): kitti, colmap, images, ...
  std::string input, output;     ///< Folders.
  std::string scene;             ///< Replaces the name of a single scene; empty: the source's.
  std::string sequence;          ///< Of KITTI.
  PairChoice choice;             ///< KITTI: steps, {1} when empty.
  double min_motion = 0.0;       ///< RequireMotion.
  GivenCalibration calibration;  ///< Of poses, images and hloc.
  bool ratios = false;           ///< Of colmap_database: match_conf.h5 from the descriptors.
  PrepareOptions options;
};

/// Throws Error.
PrepareResult RunPairs(const PairsRequest& request, const std::atomic<bool>& stop);

/// Throws Error where an HDF5 file that is read lies in the folder of a scene, whose files are replaced.
void RefuseInputsInScene(const PairsRequest& request, const std::string& folder);

}  // namespace diffsac
