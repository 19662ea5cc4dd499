#pragma once

#include <string>

#include "lab/images/image_features.h"

namespace diffsac {

/// Keypoints of images in a folder, so that an interrupted preparation goes on where it stopped and no more of them
/// than are needed stand in memory. A file for each image; one made of another version of the image (by its path, size
/// and time) or with other options is not taken.
class FeatureCache {
 public:
  FeatureCache(std::string folder, const FeatureOptions& options) : folder_(std::move(folder)), options_(options) {}

  /// Whether there is a good file. Broken ones count as none.
  bool Read(const std::string& name, const std::string& image_path, RawFeatures* features) const;
  /// Makes the folder when it is not there. Throws Error when it cannot be written.
  void Write(const std::string& name, const std::string& image_path, const RawFeatures& features) const;
  /// Removes the folder.
  void Remove() const;

 private:
  std::string PathOf(const std::string& name) const;
  std::string KeyOf(const std::string& image_path) const;

  std::string folder_;
  FeatureOptions options_;
};

}  // namespace diffsac
