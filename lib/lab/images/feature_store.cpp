#include "lab/images/feature_store.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"
#include "lab/files/files.h"

namespace diffsac {

FeatureStore::FeatureStore(const ImageSource& source, const FeatureOptions& options, const std::string& import_file,
                           const std::string& cache_folder)
    : source_(source), options_(options), cache_(cache_folder, options), sizes_(source.images.size()) {
  if (!import_file.empty()) imported_ = std::make_unique<ImportedFeatures>(import_file);
}

void FeatureStore::CheckSize(const SourceImage& image, const ImageSize& size) const {
  if (!image.camera || image.camera->size == ImageSize{} || image.camera->size == size) return;
  throw Error(image.path + ": is " + SizeText(size) + ", but its calibration is for " + SizeText(image.camera->size));
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
  std::vector<bool> kept(images.size());
  for (std::size_t k = 0; k < images.size(); ++k) {
    const SourceImage& image = source_.images[images[k]];
    kept[k] = !imported_ && cache_.Holds(image.name, image.path);
  }
  const auto all = std::ssize(images), left = all - std::count(kept.begin(), kept.end(), true);
  if (left < all)
    LogInfo("keypoints: " + std::to_string(left) + " of " + std::to_string(all) +
            " images are left, the others' are kept from before");
  std::optional<Progress> progress;
  if (left > 0) progress.emplace("keypoints", left);
  ParallelFor(all, threads, [&](std::int64_t k) {
    if (stop) return;
    Prepare(images[k], &(*problems)[k]);
    if (!kept[k]) progress->Advance();
  });
  return !stop;
}

std::ptrdiff_t FeatureStore::CountPrepared() const {
  return std::count_if(sizes_.begin(), sizes_.end(), [](const ImageSize& size) { return size.known(); });
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

namespace {

namespace fs = std::filesystem;

// What stands in a file after its key.
struct Header {
  std::int64_t width = 0, height = 0, rows = 0, cols = 0;
};

// Of one keypoint.
constexpr std::size_t kPlaceBytes = 2 * sizeof(double), kFrameBytes = 2 * sizeof(double);

template <class Value>
std::string_view BytesOf(const Value* values, Eigen::Index count) {
  return {reinterpret_cast<const char*>(values), static_cast<std::size_t>(count) * sizeof(Value)};
}

// SIFT and RootSIFT are two readings of the same values.
std::string DetectorName(FeatureKind kind) { return IsSift(kind) ? "sift" : ToString(kind); }

}  // namespace

std::string FeatureCache::PathOf(const std::string& name) const {
  return (fs::path(folder_) / (name + ".bin")).string();
}

std::string FeatureCache::KeyOf(const std::string& image_path) const {
  std::error_code code;
  const auto size = fs::file_size(image_path, code);
  const auto time = fs::last_write_time(image_path, code).time_since_epoch().count();
  return "diffsac keypoints 3\n" + image_path + "\n" + std::to_string(size) + " " + std::to_string(time) + " " +
         DetectorName(options_.kind) + " " + std::to_string(options_.max_keypoints) + " " +
         std::to_string(kContrastThreshold) + " " + std::to_string(options_.max_image_size) + "\n";
}

bool FeatureCache::Holds(const std::string& name, const std::string& image_path) const {
  const std::string key = KeyOf(image_path);
  std::string start(key.size(), '\0');
  std::ifstream file(PathOf(name), std::ios::binary);
  return file.read(start.data(), std::ssize(start)) && start == key;
}

bool FeatureCache::Read(const std::string& name, const std::string& image_path, RawFeatures* features) const {
  std::error_code code;
  if (!fs::exists(PathOf(name), code)) return false;
  const std::string content = ReadFile(PathOf(name)), key = KeyOf(image_path);
  if (!content.starts_with(key) || content.size() < key.size() + sizeof(Header)) return false;
  Header header;
  const char* values = content.data() + key.size();
  std::memcpy(&header, values, sizeof(header));
  values += sizeof(header);
  const std::size_t left = content.size() - key.size() - sizeof(header);
  const auto rows = static_cast<std::size_t>(header.rows), cols = static_cast<std::size_t>(header.cols);
  if (header.rows < 0 || header.cols < 0 || header.cols > 1024 || rows > left ||
      rows * (kPlaceBytes + kFrameBytes + cols) != left)
    return false;
  features->size = {static_cast<int>(header.width), static_cast<int>(header.height)};
  features->positions.resize(header.rows, 2);
  features->frames.resize(header.rows, 2);
  features->bytes.resize(header.rows, header.cols);
  if (rows == 0) return true;
  std::memcpy(features->positions.data(), values, rows * kPlaceBytes);
  values += rows * kPlaceBytes;
  std::memcpy(features->frames.data(), values, rows * kFrameBytes);
  values += rows * kFrameBytes;
  std::memcpy(features->bytes.data(), values, rows * cols);
  return true;
}

void FeatureCache::Write(const std::string& name, const std::string& image_path, const RawFeatures& features) const {
  fs::create_directories(folder_);
  const Header header{features.size.width, features.size.height, features.bytes.rows(), features.bytes.cols()};
  std::string content = KeyOf(image_path);
  content += BytesOf(&header, 1);
  content += BytesOf(features.positions.data(), features.positions.size());
  content += BytesOf(features.frames.data(), features.frames.size());
  content += BytesOf(features.bytes.data(), features.bytes.size());
  WriteFileAtomically(PathOf(name), content);
}

void FeatureCache::Remove() const {
  std::error_code code;
  fs::remove_all(folder_, code);
}

bool ForEachPair(const FeatureStore& store, const std::vector<SourcePair>& pairs, int threads,
                 const std::atomic<bool>& stop,
                 const std::function<void(std::int64_t, const ImageFeatures&, const ImageFeatures&)>& body) {
  const auto count = static_cast<std::int64_t>(pairs.size());
  std::map<int, std::int64_t> last_use;
  for (std::int64_t i = 0; i < count; ++i) last_use[pairs[i].image1] = last_use[pairs[i].image2] = i;
  const std::int64_t block = 8 * (threads > 0 ? threads : HardwareThreads());
  std::map<int, ImageFeatures> loaded;
  for (std::int64_t start = 0; start < count && !stop; start += block) {
    const std::int64_t end = std::min(count, start + block);
    std::vector<int> missing;
    for (std::int64_t i = start; i < end; ++i)
      for (int image : {pairs[i].image1, pairs[i].image2})
        if (loaded.try_emplace(image).second) missing.push_back(image);
    ParallelFor(static_cast<std::int64_t>(missing.size()), threads,
                [&](std::int64_t k) { loaded.at(missing[k]) = store.Load(missing[k]); });
    ParallelFor(end - start, threads, [&](std::int64_t k) {
      const SourcePair& pair = pairs[start + k];
      if (!stop) body(start + k, loaded.at(pair.image1), loaded.at(pair.image2));
    });
    std::erase_if(loaded, [&](const auto& entry) { return last_use.at(entry.first) < end; });
  }
  return !stop;
}

}  // namespace diffsac
