#include "lab/images/feature_cache.h"

#include <cstring>
#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {
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
std::string DetectorName(FeatureKind kind) { return kind == FeatureKind::kOrb ? "orb" : "sift"; }

}  // namespace

std::string FeatureCache::PathOf(const std::string& name) const {
  return (fs::path(folder_) / (name + ".bin")).string();
}

std::string FeatureCache::KeyOf(const std::string& image_path) const {
  std::error_code code;
  const auto size = fs::file_size(image_path, code);
  const auto time = fs::last_write_time(image_path, code).time_since_epoch().count();
  return "diffsac keypoints 2\n" + image_path + "\n" + std::to_string(size) + " " + std::to_string(time) + " " +
         DetectorName(options_.kind) + " " + std::to_string(options_.max_keypoints) + " " +
         std::to_string(options_.contrast_threshold) + " " + std::to_string(options_.max_image_size) + "\n";
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

}  // namespace diffsac
