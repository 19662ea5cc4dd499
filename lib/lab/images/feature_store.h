#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lab/images/image_features.h"
#include "lab/images/image_source.h"

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

/// Keypoints of images in a folder, so that an interrupted preparation goes on where it stopped and no more of them
/// than are needed stand in memory. A file for each image; one made of another version of the image (by its path, size
/// and time) or with other options is not taken.
class FeatureCache {
 public:
  FeatureCache(std::string folder, const FeatureOptions& options) : folder_(std::move(folder)), options_(options) {}

  /// Whether there is a good file. Broken ones count as none.
  bool Read(const std::string& name, const std::string& image_path, RawFeatures* features) const;
  /// Whether there is a file of this version of the image and these options; it may be broken.
  bool Holds(const std::string& name, const std::string& image_path) const;
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
  /// The same for several images on `threads` threads (0: all cores), with a bar of progress over those
  /// that are not kept from before; a line for each that was
  /// not prepared, empty for the others. False when `stop` turned true.
  bool PrepareAll(const std::vector<int>& images, int threads, const std::atomic<bool>& stop,
                  std::vector<std::string>* problems);
  /// How many images are prepared.
  std::ptrdiff_t CountPrepared() const;
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

/// Calls `body(i, first, second)` with the features of each pair's images, on up to `threads` threads (0: all cores),
/// in no fixed order within a block of pairs. Of the images, only those that the block and later pairs need are in
/// memory. False when `stop` turned true; pairs that have begun are finished.
bool ForEachPair(const FeatureStore& store, const std::vector<SourcePair>& pairs, int threads,
                 const std::atomic<bool>& stop,
                 const std::function<void(std::int64_t, const ImageFeatures&, const ImageFeatures&)>& body);

}  // namespace diffsac
