#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "lab/images/estimate_pair.h"
#include "lab/images/feature_store.h"
#include "lab/images/image_cameras.h"
#include "lab/images/photographs.h"

namespace diffsac {

/// What is known of the camera of each photograph without a calibration.
struct PhotographCameras {
  std::vector<int> camera;             ///< By image: which camera took it, from 0.
  std::vector<CameraPriorHint> hints;  ///< By image.
  std::vector<FocalSource> from;       ///< By image: where its hint comes from.
  std::vector<int> alike;   ///< By image: equal where EXIF data leave open whether one camera took them; or -1.
  bool IsOne() const;       ///< Whether one camera took all.
  bool AreDivided() const;  ///< Whether images that are alike are of several cameras.
};

/// Which camera took each of the photographs: images are of one camera where EXIF data say the same maker, model, focal
/// length and size of all of them, or `same`, and `sizes`, by image and empty where they are not known yet, are the
/// same; else each has its own. Hints are EXIF's focal lengths, where sizes are known.
PhotographCameras CamerasOfPhotographs(const std::vector<SourceImage>& images, const std::vector<ImageSize>& sizes,
                                       bool same);

/// What a pair of photographs says of the focal lengths of its images.
struct FocalsOfPair {
  std::array<int, 2> images;
  FocalEstimate focal;
  /// Whether it says anything beside the prior: what may be chance, or leaves the translation open, does not.
  bool counts = true;
};

/// Makes one camera of those that the matches say have one focal length: images of one size, or of it turned by a
/// quarter, of which EXIF data say nothing (PhotographCameras::alike). Two views know the ratio of their lengths far
/// better than either: each pair, of two lengths, gives odds for one camera, and two groups of images are joined where
/// those of all pairs between them, with what is likely before, are for it; the surest first.
void JoinCameras(const std::vector<FocalsOfPair>& pairs, PhotographCameras* cameras);

/// Gives each camera the focal length that all pairs say together, as a prior about it. What a pair says beside its
/// priors is normal, of both log f with their correlation: two views know the ratio of their lengths far better than
/// either, so that those of all cameras are found together, by Student's t. Pairs are surer than they are right: their
/// variances are multiplied until half of them agree. A length that all of them know hardly better than the prior stays
/// unknown.
void PoolFocals(const std::vector<FocalsOfPair>& pairs, PhotographCameras* cameras);

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
