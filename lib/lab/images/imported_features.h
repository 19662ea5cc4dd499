#pragma once

#include <memory>
#include <string>

#include "lab/images/image_features.h"

namespace diffsac {

/// Keypoints and descriptors made elsewhere (SuperPoint, ...), in an HDF5 file as hloc writes it: a group for each
/// image, named by its file (with folders before it or not, with extension or not), that holds
///   keypoints    N × 2, pixels of the image as it is stored, the centre of the first pixel is (0, 0)
///   descriptors  D × N (as hloc does; taken for N = D too) or N × D
///   scores       N, optional: the strongest are kept where not all are
///   image_size   width, height, optional: must be those of the image
/// Descriptors are brought to unit length and matched by their Euclidean distance. Thread-safe.
class ImportedFeatures {
 public:
  /// Throws Error, like Read, with one line that names the file and the key.
  explicit ImportedFeatures(const std::string& path);
  ~ImportedFeatures();

  /// `image_path` has the size `size`. At most `max_keypoints` (0: all).
  ImageFeatures Read(const std::string& image_path, const ImageSize& size, int max_keypoints) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace diffsac
