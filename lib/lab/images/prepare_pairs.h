#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "lab/images/image_features.h"
#include "lab/images/image_source.h"

namespace diffsac {

struct PrepareOptions {
  FeatureOptions features;
  std::string import_descriptors;  ///< A file of ImportedFeatures, instead of features of the images; empty: none.
  bool descriptors = false;        ///< Whether to write descriptors.h5.
  bool thumbnails = true;          ///< Whether to write thumbnails.h5 (lab/files/thumbnails.h).
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

}  // namespace diffsac
