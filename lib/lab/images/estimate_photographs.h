#pragma once

#include <atomic>
#include <vector>

#include "lab/images/estimate_pair.h"
#include "lab/images/feature_store.h"
#include "lab/images/image_cameras.h"
#include "lab/images/photograph_cameras.h"
#include "lab/images/photographs.h"

namespace diffsac {

/// Finds the keypoints of all photographs, one image a thread, and gives each its camera. Images that cannot be read,
/// or have no camera where a calibration is given, are taken out of the pairs, with a warning each that names them.
/// False when `stop` turned true.
bool PreparePhotographs(const ImageCameras& cameras, int threads, const std::atomic<bool>& stop, FeatureStore* store,
                        ImageSource* source);

/// Matches and estimates the pairs of the source's scene, and shows the progress. As many as pairs; those that `stop`
/// left out are not done. `cameras`: of the images, where no calibration is given.
std::vector<ImagePair> EstimatePairs(const ImageSource& source, const FeatureStore& store,
                                     const PhotographCameras& cameras, const PairOptions& options,
                                     const std::atomic<bool>& stop);

/// Estimates pairs whose matches are known.
void EstimateMatchedPairs(const PhotographCameras& cameras, const PairOptions& options, const std::atomic<bool>& stop,
                          std::vector<ImagePair>* pairs);

/// Of pairs of unknown focal lengths: cameras that have one length by all pairs are joined (JoinCameras), and their
/// pairs estimated with one; then what all pairs of a camera say of its focal length together (PoolFocals) becomes what
/// is known of it in *cameras, with which all that are done are estimated again. False when `stop` turned true: the
/// rest is as it was.
bool EstimateWithPooledFocals(const PairOptions& options, const std::atomic<bool>& stop, PhotographCameras* cameras,
                              std::vector<ImagePair>* pairs);

}  // namespace diffsac
