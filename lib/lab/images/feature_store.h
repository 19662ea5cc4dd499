#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "lab/images/feature_cache.h"
#include "lab/images/image_source.h"
#include "lab/images/imported_features.h"

namespace diffsac {

/// The features of a source's images: found once and kept in files, or imported. Different images may be asked for from
/// different threads.
class FeatureStore {
 public:
  /// `import_file` empty: features are found and kept in `cache_folder`.
  FeatureStore(const ImageSource& source, const FeatureOptions& options, const std::string& import_file,
               const std::string& cache_folder);

  /// Makes sure that Load gives the features of an image. False, with a line in `problem`, when the image cannot be
  /// read, has not the size of its calibration, or what is imported of it makes no sense. Throws Error for anything
  /// else.
  bool Prepare(int image, std::string* problem);
  /// The same for several images on `threads` threads (0: all cores), with a bar of progress; a line for each that was
  /// not prepared, empty for the others. False when `stop` turned true.
  bool PrepareAll(const std::vector<int>& images, int threads, const std::atomic<bool>& stop,
                  std::vector<std::string>* problems);
  /// After Prepare, as Load.
  const ImageSize& SizeOf(int image) const { return sizes_[image]; }
  ImageFeatures Load(int image) const;
  DescriptorDistance distance() const;
  void RemoveCache() const { cache_.Remove(); }

 private:
  void CheckSize(const SourceImage& image, const ImageSize& size) const;

  const ImageSource& source_;
  FeatureOptions options_;
  FeatureCache cache_;
  std::unique_ptr<ImportedFeatures> imported_;
  std::vector<ImageSize> sizes_;
};

}  // namespace diffsac
