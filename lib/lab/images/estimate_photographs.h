#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/ground_truth/example.h"
#include "lab/images/feature_store.h"
#include "lab/images/given_pairs.h"
#include "lab/images/image_cameras.h"
#include "lab/images/match_pair.h"
#include "lab/images/photograph_cameras.h"
#include "lab/images/photographs.h"

namespace diffsac {

/// A pair of photographs, matched and estimated.
struct EstimatedPair {
  bool done = false;
  Example example;       ///< Of the task; its id is "NAME1-NAME2".
  MatchIndices matches;  ///< Keypoints of image 1 and 2 behind each of the example's points.
  Estimate estimate;
  double ms_matching = 0.0;
  std::array<FocalSource, 2> focal_from = {};  ///< Of either image.
  std::array<int, 2> camera = {-1, -1};        ///< Of either image, from 0; -1: its calibration is given.
};

/// What is done with each pair of photographs.
struct PairEstimation {
  const RobustEstimator& method;
  Task task{};
  double inlier_threshold_px = 1.0;
  std::uint64_t seed = 0;  ///< Of every pair, so that two of the photographs alone give the same.
  int threads = 0;         ///< 0: all cores. What comes out does not depend on it.
};

/// Finds the keypoints of all photographs, one image a thread, and gives each its camera. Images that cannot be read,
/// or have no camera where a calibration is given, are taken out of the pairs, with a warning each that names them.
/// False when `stop` turned true.
bool PreparePhotographs(const ImageCameras& cameras, int threads, const std::atomic<bool>& stop, FeatureStore* store,
                        ImageSource* source);

/// Matches and estimates the pairs of the source's scene, and shows the progress. As many as pairs; those that `stop`
/// left out are not done. `cameras`: of the images, where no calibration is given.
std::vector<EstimatedPair> EstimatePairs(const ImageSource& source, const FeatureStore& store,
                                         const PhotographCameras& cameras, const PairEstimation& estimation,
                                         const std::atomic<bool>& stop);

/// The same of pairs that came with their matches; `source`: SourceOf them.
std::vector<EstimatedPair> EstimateGivenPairs(const ImageSource& source, GivenPairs given,
                                              const PhotographCameras& cameras, const PairEstimation& estimation,
                                              const std::atomic<bool>& stop);

/// Of pairs of unknown focal lengths: cameras that have one length by all pairs are joined (JoinCameras), and their
/// pairs estimated with one; then what all pairs of a camera say of its focal length together (PoolFocals) becomes what
/// is known of it in *cameras, with which all that are done are estimated again. False when `stop` turned true: the
/// rest is as it was.
bool EstimateWithPooledFocals(const ImageSource& source, const PairEstimation& estimation,
                              const std::atomic<bool>& stop, PhotographCameras* cameras,
                              std::vector<EstimatedPair>* pairs);

}  // namespace diffsac
