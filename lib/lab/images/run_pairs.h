#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "diffsac/core/registry.h"
#include "lab/images/image_features.h"
#include "lab/images/image_source.h"

namespace diffsac {

struct PrepareOptions {
  FeatureOptions features;
  std::string import_descriptors;  ///< A file of ImportedFeatures, instead of features of the images; empty: none.
  bool descriptors = false;        ///< Whether to write descriptors.h5.
  bool thumbnails = true;          ///< Whether to write thumbnails.h5 (pictures.h).
  bool overwrite = false;          ///< Whether scenes that are there are made again.
  int max_pairs = 0;               ///< At most so many pairs a scene, evenly spaced; 0: all.
  /// Pairs with fewer matches within `true_match_px` of the truth are left out: those that do not overlap. 0 keeps all.
  int min_true_matches = 0;
  /// Pairs whose pose turns by more degrees when it is refined on its matches are left out (TruthDisagreementDegrees,
  /// with true_match_px and min_true_matches): those whose source is wrong. 0 keeps all.
  double max_disagreement_deg = 0.0;
  /// Only pairs of whose matches such a share, least and greatest, is within `true_match_px` of the truth: hard pairs.
  /// Empty: any.
  std::vector<double> true_share = {};
  double true_match_px = 1.0;  ///< Pixels; of the Sampson distance, or the transfer error of a homography.
  int threads = 0;             ///< 0: all cores. The files do not depend on it.
  void Check() const;          ///< Throws Error.
};

/// How a preparation ended.
struct PrepareResult {
  bool finished = true;  ///< False: a request to stop ended it.
  int written = 0;       ///< Scenes.
  int already_there = 0;
  std::vector<std::string> left_out;  ///< A line for each image that could not be used; it names the file.
};

/// Matches the pairs of a source and writes a folder `output`/<scene> for each of its scenes, when that scene is
/// complete (CorrespondenceScene reads it). Matches are mutual nearest neighbours with their ratio; correspondences
/// that repeat another one, which SIFT gives for keypoints with two orientations, are left out; pixels are those of a
/// camera without distortion. Scenes that are there already stay. Images that cannot be read, or differ from their
/// calibration in size, are left out with their pairs, with a warning each. Keypoints are kept in a hidden folder of
/// `output` until all scenes are complete, so that a call after an interruption goes on; in memory are only those that
/// the next pairs need. Shows its progress. Throws Error: nothing can be written, a scene is left without pairs (after
/// the others).
PrepareResult PreparePairs(const ImageSource& source, const PrepareOptions& options, const std::string& output,
                           const std::atomic<bool>& stop);

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
