#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "lab/images/image_features.h"

namespace diffsac {

/// The command `diffsac_prepare tutorial`.
struct TutorialRequest {
  std::string input;        ///< A scene in the tutorial's layout.
  std::string images;       ///< Folder of its images; empty: `input`/images.
  FeatureOptions features;  ///< SIFT or RootSIFT.
  bool overwrite = false;   ///< Whether descriptors that are there are made again.
  int threads = 0;          ///< 0: all cores.
};

struct TutorialResult {
  bool finished = true;  ///< False: a request to stop ended it, nothing was written.
  bool already_there = false;
  std::int64_t pairs = 0, images = 0;
  /// Different matched places in the images, and those with a keypoint within a pixel (DescribePlaces).
  std::int64_t places = 0, found = 0;
};

/// Adds descriptors.h5 and sizes.h5 to a scene that has matches but no descriptors, from its images: every place that
/// is matched in an image is described once (DescribePlaces). In memory: 128 bytes a place, and its coordinates. Throws
/// Error: no scene, pairs that are not named img1-img2, images that are missing or cannot be read.
TutorialResult AddTutorialDescriptors(const TutorialRequest& request, const std::atomic<bool>& stop);

}  // namespace diffsac
