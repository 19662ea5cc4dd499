#pragma once

#include <string>
#include <vector>

#include "lab/images/estimate_pair.h"
#include "lab/images/image_features.h"
#include "lab/images/image_source.h"

namespace diffsac {

/// Where a camera without distortion sees each of these pixels; NaN where none could. As they are without a camera.
PointMatrix StraightPositions(const std::optional<LensCamera>& camera, PointMatrix positions);

/// One pair, matched.
struct MatchedPair {
  Example example;
  std::vector<DescriptorMatch> matches;  ///< The rows of the features behind each correspondence.
};

/// Mutual nearest neighbours as correspondences of a camera without distortion, with what the source knows to be true.
/// Of equal correspondences, which SIFT gives for keypoints with two orientations, the one with the best ratio stays.
/// Keypoints that no camera without distortion could see (a fisheye's beyond 90°) are left out.
MatchedPair MatchPair(const ImageSource& source, const SourcePair& pair, const ImageFeatures& first,
                      const ImageFeatures& second, DescriptorDistance distance);

/// Keypoints of both images, at the same time on several threads (0: all cores), and their mutual nearest neighbours
/// (MatchPair), as diffsac_prepare finds them; the id has folders where the names are equal. Without a calibration the
/// hints are the focal lengths that EXIF data say (ExifFocalPx), of the images as they were read. Throws Error, before
/// the keypoints where it can: a file that is no image, or truncated; an image without keypoints; a calibration that is
/// none (ImageCameras).
ImagePair MatchTwoImages(const std::string& path1, const std::string& path2, const FeatureOptions& options,
                         const GivenCalibration& calibration, int threads = 0);

}  // namespace diffsac
