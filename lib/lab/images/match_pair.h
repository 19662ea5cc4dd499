#pragma once

#include <string>
#include <vector>

#include "lab/images/image_features.h"
#include "lab/images/image_source.h"
#include "lab/truth/example.h"

namespace diffsac {

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

/// Two images, matched, with the time that it took.
struct MatchedImages {
  Example pair;  ///< Its id is "NAME1-NAME2"; of no task as yet (SetTask); without truth.
  double ms_keypoints = 0.0, ms_matching = 0.0;
};

/// Keypoints of both images, at the same time on several threads (0: all cores), and their mutual nearest neighbours
/// (MatchPair), as diffsac_prepare finds them. Without a calibration the hints are the focal lengths that EXIF data say
/// (ExifFocalPx), of the images as they were read. Throws Error, before the keypoints where it can: a file that is no
/// image, or truncated; an image without keypoints; a calibration that is none (ImageCameras).
MatchedImages MatchTwoImages(const std::string& path1, const std::string& path2, const FeatureOptions& options,
                             const GivenCalibration& calibration, int threads = 0);

/// Matches that something else made, in a NumPy file (convert.py, "matches", says of which) or a text file: x1 y1 x2 y2
/// of each, in pixels, the centre of the first one (0, 0); then what there is of ratio, log_size and angle (as
/// `diffsac_pair --matches` writes them). With a header columns are found by these names, in any order, and score, in
/// [0, 1] and higher for better, may stand for ratio. Equal matches stay.
struct GivenMatches {
  std::string file;
  std::vector<ImageSize> sizes;  ///< Of the images; one stands for both, none: unknown.
};

/// The same of such a file, in no time. Throws Error: a file that cannot be read, a
/// line of it, a calibration that is none or that needs the images' sizes.
MatchedImages ReadMatches(const GivenMatches& given, const GivenCalibration& calibration);

}  // namespace diffsac
