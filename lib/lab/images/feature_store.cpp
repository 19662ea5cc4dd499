#include "lab/images/feature_store.h"

#include <H5Cpp.h>
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/images/image_source.h"

namespace diffsac {

namespace fs = std::filesystem;

struct ImportedFeatures::Impl {
  std::string path;
  H5::H5File file;
};

namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Asking for "a/b" when there is no "a" is an error of the library's, not a no.
bool HasGroup(const H5::H5File& file, const fs::path& name) {
  if (name.has_parent_path() && !HasGroup(file, name.parent_path())) return false;
  return file.nameExists(name.string()) && file.childObjType(name.string()) == H5O_TYPE_GROUP;
}

// Keypoints may lie on the border of the last pixel, and half a pixel beyond by another convention.
constexpr double kOutsidePx = 1.0;

// The names under which a file may list an image: its path with ever fewer folders, its stem.
std::vector<std::string> NamesOf(const std::string& image_path) {
  const fs::path whole = fs::path(image_path).lexically_normal();
  std::vector<fs::path> parts(whole.begin(), whole.end());
  std::vector<std::string> names;
  fs::path name;
  for (auto part = parts.rbegin(); part != parts.rend() && *part != "/" && *part != ".."; ++part) {
    name = name.empty() ? *part : *part / name;
    names.push_back(name.string());
  }
  names.insert(names.end(), {whole.stem().string(), ImageName(image_path)});
  return names;
}

// One image's group, read as it stands.
struct Group {
  std::string place;  // file and key
  Numbers keypoints, descriptors;
  std::optional<Numbers> scores, image_size;
};

Group ReadGroup(const std::string& path, const H5::H5File& file, const std::string& image_path) {
  const std::lock_guard lock(Hdf5Mutex());
  std::string place = path + ": " + fs::path(image_path).filename().string();
  const auto read = [&](const H5::Group& group, const std::string& name, const char* key) -> std::optional<Numbers> {
    place = path + ": " + name + "/" + key;
    if (!group.nameExists(key)) return {};
    return ReadNumbers(group.openDataSet(key), place);
  };
  const auto needed = [&](const H5::Group& group, const std::string& name, const char* key) {
    std::optional<Numbers> numbers = read(group, name, key);
    if (!numbers) throw Error(path + ": " + name + ": it has no " + key);
    return std::move(*numbers);
  };
  return WithClearErrors(place, [&]() -> Group {
    for (const std::string& name : NamesOf(image_path)) {
      if (!HasGroup(file, name)) continue;
      const H5::Group group = file.openGroup(name);
      return {path + ": " + name, needed(group, name, "keypoints"), needed(group, name, "descriptors"),
              read(group, name, "scores"), read(group, name, "image_size")};
    }
    throw Error(path + ": there is no group " + fs::path(image_path).filename().string());
  });
}

PointMatrix PositionsOf(const Group& group, const ImageSize& size) {
  const Numbers& numbers = group.keypoints;
  if (numbers.shape.size() != 2 || numbers.shape[1] != 2)
    throw Error(group.place + "/keypoints: expected Nx2, found " + ShapeText(numbers));
  const PointMatrix positions =
      Eigen::Map<const Rows>(numbers.values.data(), static_cast<Eigen::Index>(numbers.shape[0]), 2);
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    const double x = positions(i, 0), y = positions(i, 1);
    if (!(x >= -kOutsidePx && y >= -kOutsidePx && x <= size.width - 1 + kOutsidePx &&
          y <= size.height - 1 + kOutsidePx))
      throw Error(group.place + "/keypoints: keypoint " + std::to_string(i) + " lies outside the " + SizeText(size) +
                  " image: was it found in a copy of another size?");
  }
  return positions;
}

DescriptorMatrix DescriptorsOf(const Group& group, Eigen::Index count) {
  const Numbers& numbers = group.descriptors;
  const auto wanted = static_cast<hsize_t>(count);
  if (numbers.shape.size() != 2 || (numbers.shape[0] != wanted && numbers.shape[1] != wanted))
    throw Error(group.place + "/descriptors: expected DxN or NxD with N = " + std::to_string(count) + ", found " +
                ShapeText(numbers));
  const Eigen::Map<const Rows> stored(numbers.values.data(), static_cast<Eigen::Index>(numbers.shape[0]),
                                      static_cast<Eigen::Index>(numbers.shape[1]));
  if (!stored.allFinite()) throw Error(group.place + "/descriptors: a value is not finite");
  DescriptorMatrix rows = numbers.shape[1] == wanted ? DescriptorMatrix(stored.transpose().cast<float>())
                                                     : DescriptorMatrix(stored.cast<float>());
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (const float length = rows.row(i).norm(); length > 0.0f) rows.row(i) /= length;
  return rows;
}

// Rows to keep: the best scores, in their order; without scores the first ones.
std::vector<Eigen::Index> Strongest(const Group& group, Eigen::Index count, int max_keypoints) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  if (group.scores) {
    if (group.scores->values.size() != order.size())
      throw Error(group.place + "/scores: expected " + std::to_string(count) + " values, found " +
                  ShapeText(*group.scores));
    const std::vector<double>& scores = group.scores->values;
    std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return scores[a] > scores[b]; });
  }
  if (max_keypoints > 0 && order.size() > static_cast<std::size_t>(max_keypoints))
    order.resize(static_cast<std::size_t>(max_keypoints));
  return order;
}

void CheckImageSize(const Group& group, const ImageSize& size) {
  if (!group.image_size) return;
  const std::vector<double>& values = group.image_size->values;
  if (values.size() != 2 || values[0] != size.width || values[1] != size.height)
    throw Error(group.place + "/image_size: the image is " + SizeText(size));
}

}  // namespace

ImportedFeatures::ImportedFeatures(const std::string& path) {
  const std::lock_guard lock(Hdf5Mutex());
  std::error_code code;
  if (!fs::is_regular_file(path, code)) throw Error(path + ": no such file");
  impl_ = WithClearErrors(path, [&] { return std::make_unique<Impl>(Impl{path, OpenHdf5(path)}); });
}

ImportedFeatures::~ImportedFeatures() {
  const std::lock_guard lock(Hdf5Mutex());
  impl_.reset();
}

ImageFeatures ImportedFeatures::Read(const std::string& image_path, const ImageSize& size, int max_keypoints) const {
  const Group group = ReadGroup(impl_->path, impl_->file, image_path);
  CheckImageSize(group, size);
  const PointMatrix positions = PositionsOf(group, size);
  const DescriptorMatrix descriptors = DescriptorsOf(group, positions.rows());
  const std::vector<Eigen::Index> kept = Strongest(group, positions.rows(), max_keypoints);
  const auto count = static_cast<Eigen::Index>(kept.size());
  ImageFeatures features{size, PointMatrix(count, 2), {}, DescriptorMatrix(count, descriptors.cols())};
  for (Eigen::Index i = 0; i < count; ++i) {
    features.positions.row(i) = positions.row(kept[i]);
    features.descriptors.row(i) = descriptors.row(kept[i]);
  }
  return features;
}

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
