#pragma once

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

}  // namespace diffsac
