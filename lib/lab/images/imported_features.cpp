#include "lab/images/imported_features.h"

#include <H5Cpp.h>
#include <algorithm>
#include <filesystem>
#include <mutex>
#include <numeric>
#include <optional>

#include "diffsac/core/status.h"
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

}  // namespace diffsac
