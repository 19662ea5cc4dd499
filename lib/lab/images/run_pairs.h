#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "diffsac/core/registry.h"
#include "lab/images/image_source.h"
#include "lab/images/prepare_pairs.h"

namespace diffsac {

/// The command `diffsac_prepare pairs`.
struct PairsRequest {
  std::string format;            ///< Of those registered (ImageFormat): kitti, colmap, images, ...
  std::string input, output;     ///< Folders.
  std::string scene;             ///< Replaces the name of a single scene; empty: the source's.
  std::string sequence;          ///< Of KITTI.
  PairChoice choice;             ///< KITTI: steps, {1} when empty.
  GivenCalibration calibration;  ///< Of images.
  bool ratios = false;           ///< Of colmap_database: match_conf.h5 from the descriptors.
  PrepareOptions options;
};

/// Throws Error.
PrepareResult RunPairs(const PairsRequest& request, const std::atomic<bool>& stop);

/// Throws Error where an HDF5 file that is read lies in the folder of a scene, whose files are replaced.
void RefuseInputsInScene(const PairsRequest& request, const std::string& folder);

/// What images and their truth can come as: `diffsac_prepare pairs --format NAME`. Registered at the end of the file
/// that reads it:
/// ```
/// const Registered<ImageFormat> kStrecha("strecha", {.read = [](const PairsRequest& request) { ... }});
/// ```
/// A request that gives what its format does not look at is an error.
struct ImageFormat {
  static constexpr const char* kKind = "format";
  std::function<ImageSource(const PairsRequest&)> read = {};
  bool takes_calibration = false;  ///< --calibration, --focal and --center, where the images come without one.
  bool takes_sequence = false;     ///< --sequence, which it needs then.
  bool takes_ratios = false;       ///< --ratios, for matches that come without.
  bool chooses_pairs = false;      ///< `read` chooses the pairs itself.
  /// Instead of `read`, for correspondences that come with the images: writes their scenes. Nothing is matched.
  std::function<PrepareResult(const PairsRequest&, const std::atomic<bool>& stop)> write = {};
};

}  // namespace diffsac
