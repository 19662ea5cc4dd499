#include "lab/images/imported_features.h"

#include <H5Cpp.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <optional>

#include "diffsac/core/status.h"
#include "lab/files/hdf5_input.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/images/image_source.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Keypoints may lie on the border of the last pixel, and half a pixel beyond by another convention.
constexpr double kOutsidePx = 1.0;

std::string SizeText(const ImageSize& size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

// The names under which a file may list an image: its path with ever fewer folders, its stem.
std::vector<std::string> NamesOf(const std::string& image_path) {
  std::vector<std::string> names;
  fs::path name;
  const fs::path whole = fs::path(image_path).lexically_normal();
  std::vector<std::string> parts;
  for (const fs::path& part : whole) parts.push_back(part.string());
  for (auto part = parts.rbegin(); part != parts.rend() && *part != "/" && *part != ".."; ++part) {
    name = name.empty() ? fs::path(*part) : fs::path(*part) / name;
    names.push_back(name.string());
  }
  names.push_back(whole.stem().string());
  names.push_back(ImageName(image_path));
  return names;
}

// One image's group, read as it stands. The lock is held by the caller.
struct Group {
  std::string place;  // file and key
  Numbers keypoints, descriptors;
  std::optional<Numbers> scores, image_size;
};

}  // namespace

struct ImportedFeatures::Impl {
  std::string path;
  H5::H5File file;

  // Asking for "a/b" when there is no "a" is an error of the library's, not a no.
  bool HasGroup(const std::string& name) const {
    std::string prefix;
    for (const fs::path& part : fs::path(name)) {
      prefix += (prefix.empty() ? "" : "/") + part.string();
      if (!file.nameExists(prefix) || file.childObjType(prefix) != H5O_TYPE_GROUP) return false;
    }
    return !prefix.empty();
  }

  static std::optional<Numbers> Find(const H5::Group& group, const std::string& place, const char* key) {
    if (!group.nameExists(key)) return {};
    return ReadNumbers(group.openDataSet(key), place + "/" + key);
  }

  static Numbers Need(const H5::Group& group, const std::string& place, const char* key) {
    std::optional<Numbers> numbers = Find(group, place, key);
    if (!numbers) throw Error(place + ": it has no " + key);
    return std::move(*numbers);
  }

  Group ReadGroup(const std::string& image_path) const {
    const std::lock_guard lock(Hdf5Mutex());
    try {
      for (const std::string& name : NamesOf(image_path)) {
        if (!HasGroup(name)) continue;
        const H5::Group group = file.openGroup(name);
        Group read{path + ": " + name, {}, {}, {}, {}};
        read.keypoints = Need(group, read.place, "keypoints");
        read.descriptors = Need(group, read.place, "descriptors");
        read.scores = Find(group, read.place, "scores");
        read.image_size = Find(group, read.place, "image_size");
        return read;
      }
    } catch (const H5::Exception& e) {
      throw Error(path + ": " + fs::path(image_path).filename().string() + ": " + Describe(e));
    }
    throw Error(path + ": there is no group " + fs::path(image_path).filename().string());
  }
};

namespace {

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

ImportedFeatures::ImportedFeatures(const std::string& path) : impl_(std::make_unique<Impl>()) {
  std::error_code code;
  if (!fs::is_regular_file(path, code)) throw Error(path + ": no such file");
  const std::lock_guard lock(Hdf5Mutex());
  H5::Exception::dontPrint();
  impl_->path = path;
  try {
    impl_->file = OpenHdf5(path);
  } catch (const H5::Exception& e) {
    throw Error(path + ": cannot be opened: " + Describe(e));
  }
}

ImportedFeatures::~ImportedFeatures() {
  const std::lock_guard lock(Hdf5Mutex());
  impl_.reset();
}

ImageFeatures ImportedFeatures::Read(const std::string& image_path, const ImageSize& size, int max_keypoints) const {
  const Group group = impl_->ReadGroup(image_path);
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

}  // namespace diffsac
