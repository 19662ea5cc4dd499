#pragma once

#include <string>
#include <vector>

#include "diffsac/data/two_view.h"

namespace diffsac {

struct FeatureOptions {
  int max_keypoints = 8000;          ///< The strongest are kept; 0 keeps all.
  double contrast_threshold = 0.04;  ///< Of SIFT's detector; lower finds more and weaker keypoints.
  int max_image_size = 0;            ///< Larger images are reduced to this longer side, in pixels; 0: never.
  void Check() const;                ///< Throws Error.
};

/// The keypoints of one image, strongest first.
struct ImageFeatures {
  ImageSize size;                ///< Of the file's pixels, whatever its orientation flag says.
  PointMatrix positions;         ///< N × 2, pixels of the file, the centre of the first pixel is (0, 0).
  DescriptorMatrix descriptors;  ///< N × 128, of unit length.
};

/// SIFT (Lowe, "Distinctive image features from scale-invariant keypoints", IJCV 2004), the roots of the L1-normalised
/// values as descriptor (RootSIFT: Arandjelović and Zisserman, "Three things everyone should know to improve object
/// retrieval", CVPR 2012). An image without texture has no keypoints. Throws Error when the file is no image.
ImageFeatures ExtractRootSift(const std::string& path, const FeatureOptions& options);

/// Width and height of an image file. Throws Error when it is none.
ImageSize ReadImageSize(const std::string& path);

struct DescriptorMatch {
  int first = 0, second = 0;  ///< Rows.
  double ratio = 1.0;         ///< Distance of `first` to its nearest row over that to the next one, in [0, 1].
};

/// All pairs of rows that are each other's nearest, in the order of the first; nothing is thrown away by its ratio.
/// Rows must be of unit length. Equally near rows: the lower index.
std::vector<DescriptorMatch> MatchMutually(const DescriptorMatrix& first, const DescriptorMatrix& second);

}  // namespace diffsac
