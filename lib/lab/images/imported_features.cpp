#include "lab/images/imported_features.h"

#include <H5Cpp.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "diffsac/core/status.h"
#include "lab/files/hdf5_input.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/images/image_source.h"

namespace diffsac {

namespace fs = std::filesystem;

namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A file whose groups hold data sets. All calls happen under the library's lock, which the caller holds.
class GroupFile {
 public:
  explicit GroupFile(const std::string& path) : path_(path) {
    H5::Exception::dontPrint();
    std::error_code code;
    if (!fs::is_regular_file(path, code)) throw Error(path + ": no such file");
    try {
      file_ = OpenHdf5(path);
    } catch (const H5::Exception& e) {
      throw Error(path + ": not a readable HDF5 file, or truncated: " + Describe(e));
    }
  }

  // Asking for "a/b" when there is no "a" is an error of the library's, not a no.
  bool HasGroup(const std::string& name) const {
    std::string prefix;
    for (const fs::path& part : fs::path(name)) {
      prefix += (prefix.empty() ? "" : "/") + part.string();
      if (!file_.nameExists(prefix) || file_.childObjType(prefix) != H5O_TYPE_GROUP) return false;
    }
    return !prefix.empty();
  }

  const std::string& path() const { return path_; }
  std::string Place(const std::string& group, const char* name) const { return path_ + ": " + group + "/" + name; }

  std::optional<Numbers> Read(const std::string& group, const char* name) const {
    try {
      const H5::Group opened = file_.openGroup(group);
      if (!opened.nameExists(name)) return {};
      return ReadNumbers(opened.openDataSet(name), Place(group, name));
    } catch (const H5::Exception& e) {
      throw Error(Place(group, name) + ": damaged or truncated: " + Describe(e));
    }
  }

 private:
  std::string path_;
  H5::H5File file_;
};

// Keypoints may lie on the border of the last pixel, and half a pixel beyond by another convention.
constexpr double kOutsidePx = 1.0;

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
  GroupFile file;
};

namespace {

Numbers Needed(const GroupFile& file, const std::string& group, const char* name) {
  std::optional<Numbers> numbers = file.Read(group, name);
  if (!numbers) throw Error(file.path() + ": " + group + ": it has no " + name);
  return std::move(*numbers);
}

Group ReadGroup(const GroupFile& file, const std::string& image_path) {
  const std::lock_guard lock(Hdf5Mutex());
  try {
    for (const std::string& name : NamesOf(image_path))
      if (file.HasGroup(name))
        return {file.path() + ": " + name, Needed(file, name, "keypoints"), Needed(file, name, "descriptors"),
                file.Read(name, "scores"), file.Read(name, "image_size")};
  } catch (const H5::Exception& e) {
    throw Error(file.path() + ": " + fs::path(image_path).filename().string() + ": " + Describe(e));
  }
  throw Error(file.path() + ": there is no group " + fs::path(image_path).filename().string());
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
  impl_ = std::make_unique<Impl>(GroupFile(path));
}

ImportedFeatures::~ImportedFeatures() {
  const std::lock_guard lock(Hdf5Mutex());
  impl_.reset();
}

ImageFeatures ImportedFeatures::Read(const std::string& image_path, const ImageSize& size, int max_keypoints) const {
  const Group group = ReadGroup(impl_->file, image_path);
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
