#include "lab/images/feature_store.h"

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"

namespace diffsac {

FeatureStore::FeatureStore(const ImageSource& source, const FeatureOptions& options, const std::string& import_file,
                           const std::string& cache_folder)
    : source_(source), options_(options), cache_(cache_folder, options), sizes_(source.images.size()) {
  if (!import_file.empty()) imported_ = std::make_unique<ImportedFeatures>(import_file);
}

void FeatureStore::CheckSize(const SourceImage& image, const ImageSize& size) const {
  if (!image.camera || image.camera->size == ImageSize{} || image.camera->size == size) return;
  const ImageSize& expected = image.camera->size;
  throw Error(image.path + ": is " + std::to_string(size.width) + "x" + std::to_string(size.height) +
              ", but its calibration is for " + std::to_string(expected.width) + "x" + std::to_string(expected.height));
}

bool FeatureStore::Prepare(int index, std::string* problem) {
  const SourceImage& image = source_.images[index];
  RawFeatures raw;
  bool is_new = false;
  try {
    if (imported_) {
      raw.size = ReadImageSize(image.path);
    } else if (!cache_.Read(image.name, image.path, &raw)) {
      raw = ExtractRawFeatures(image.path, options_);
      is_new = true;
    }
    CheckSize(image, raw.size);
    // What is wrong with a file of imports is said before the work begins.
    if (imported_) imported_->Read(image.path, raw.size, options_.max_keypoints);
  } catch (const Error& error) {
    *problem = error.what();
    return false;
  }
  if (is_new) cache_.Write(image.name, image.path, raw);
  sizes_[index] = raw.size;
  return true;
}

bool FeatureStore::PrepareAll(const std::vector<int>& images, int threads, const std::atomic<bool>& stop,
                              std::vector<std::string>* problems) {
  problems->assign(images.size(), "");
  Progress progress("keypoints", static_cast<std::int64_t>(images.size()));
  ParallelFor(static_cast<std::int64_t>(images.size()), threads, [&](std::int64_t k) {
    if (stop) return;
    Prepare(images[k], &(*problems)[k]);
    progress.Advance();
  });
  return !stop;
}

ImageFeatures FeatureStore::Load(int index) const {
  const SourceImage& image = source_.images[index];
  if (imported_) return imported_->Read(image.path, sizes_[index], options_.max_keypoints);
  RawFeatures raw;
  if (!cache_.Read(image.name, image.path, &raw))
    throw Error(image.path + ": its keypoints were removed, or the image was changed, while they were needed");
  return FeaturesFromRaw(raw, options_.kind);
}

DescriptorDistance FeatureStore::distance() const {
  return imported_ ? DescriptorDistance::kEuclidean : DistanceOf(options_.kind);
}

}  // namespace diffsac
