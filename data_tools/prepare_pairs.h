#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "data_tools/image_features.h"
#include "data_tools/image_source.h"

namespace diffsac {

struct PrepareOptions {
  FeatureOptions features;
  bool descriptors = false;  ///< Whether to write descriptors.h5.
  int max_pairs = 0;         ///< At most so many pairs a scene, evenly spaced; 0: all.
  /// Pairs with fewer matches within `true_match_px` of the truth are left out: those that do not overlap. 0 keeps all.
  int min_true_matches = 0;
  double true_match_px = 1.0;  ///< Pixels; of the Sampson distance, or the transfer error of a homography.
  int threads = 0;             ///< 0: all cores. The files do not depend on it.
  void Check() const;          ///< Throws Error.
};

/// Matches the pairs of a source and writes a folder `output`/<scene> for each of its scenes, when that scene is
/// complete (CorrespondenceScene reads it). Matches are mutual nearest neighbours of RootSIFT with their ratio;
/// correspondences that repeat another one, which SIFT gives for keypoints with two orientations, are left out; pixels
/// are those of a camera without distortion. Shows its progress. Returns false, with the scenes that were finished in
/// place, once `stop` is true. Throws Error for images that cannot be read or differ from their calibration in size.
bool PreparePairs(const ImageSource& source, const PrepareOptions& options, const std::string& output,
                  const std::atomic<bool>& stop);

/// The command `diffsac_prepare pairs`.
struct PairsRequest {
  std::string format;            ///< kitti, strecha, colmap, homographies, adelaidermf or images
  std::string input, output;     ///< Folders.
  std::string scene;             ///< Replaces the name of a single scene; empty: the source's.
  std::string sequence;          ///< Of KITTI.
  std::vector<int> steps = {1};  ///< Of KITTI.
  std::string calibration;       ///< Of images.
  PrepareOptions options;
};

/// Returns false when `stop` ended it. Throws Error.
bool RunPairs(const PairsRequest& request, const std::atomic<bool>& stop);

}  // namespace diffsac
