#include "lab/images/hloc_files.h"

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

  // The groups that directly hold a data set of this name, at any depth, in the order of their names.
  std::vector<std::string> GroupsWith(const std::string& data_set) const {
    struct Search {
      std::string ending;
      std::vector<std::string> groups;
    } search{"/" + data_set, {}};
    const auto visit = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
      auto* s = static_cast<Search*>(out);
      const std::string path = name;
      if (path.ends_with(s->ending)) s->groups.push_back(path.substr(0, path.size() - s->ending.size()));
      return 0;
    };
    if (H5Lvisit(file_.getId(), H5_INDEX_NAME, H5_ITER_INC, visit, &search) < 0)
      throw Error(path_ + ": damaged or truncated: its groups cannot be listed");
    return std::move(search.groups);
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

PointMatrix ReadFrames(const GroupFile& file, const std::string& name, std::size_t count) {
  const std::optional<Numbers> scales = file.Read(name, "scales"), angles = file.Read(name, "oris");
  if (!scales || !angles) return {};
  PointMatrix frames(static_cast<Eigen::Index>(count), 2);
  for (const auto& [key, numbers] : {std::pair("scales", &*scales), std::pair("oris", &*angles)})
    if (numbers->values.size() != count)
      throw Error(file.Place(name, key) + ": expected " + std::to_string(count) + " values, one a keypoint, found " +
                  ShapeText(*numbers));
  for (std::size_t i = 0; i < count; ++i)
    frames.row(static_cast<Eigen::Index>(i)) << std::log(scales->values[i]),
        angles->values[i] * std::numbers::pi / 180.0;
  if (!frames.allFinite()) throw Error(file.Place(name, "scales") + ": expected sizes above 0 and finite oris");
  return frames;
}

HlocImage ReadImage(const GroupFile& file, const std::string& name) {
  const Numbers keypoints = *file.Read(name, "keypoints");
  if (keypoints.shape.size() != 2 || keypoints.shape[1] != 2)
    throw Error(file.Place(name, "keypoints") + ": expected Nx2, found " + ShapeText(keypoints));
  HlocImage image{name, {}, {}, {}};
  image.keypoints = Eigen::Map<const Rows>(keypoints.values.data(), static_cast<Eigen::Index>(keypoints.shape[0]), 2);
  if (!image.keypoints.allFinite()) throw Error(file.Place(name, "keypoints") + ": a value is not finite");
  if (const std::optional<Numbers> size = file.Read(name, "image_size")) {
    const std::vector<double>& v = size->values;
    if (v.size() != 2 || !(v[0] >= 1.0 && v[0] < 1e9 && v[1] >= 1.0 && v[1] < 1e9))
      throw Error(file.Place(name, "image_size") + ": expected width and height");
    image.size = {static_cast<int>(v[0]), static_cast<int>(v[1])};
  }
  image.frames = ReadFrames(file, name, static_cast<std::size_t>(image.keypoints.rows()));
  return image;
}

std::vector<HlocImage> ReadImages(const std::string& path) {
  const GroupFile file(path);
  std::vector<HlocImage> images;
  for (const std::string& name : file.GroupsWith("keypoints")) {
    try {
      images.push_back(ReadImage(file, name));
    } catch (const Error& error) {
      // Its place among the names stays, so that its pairs are known.
      images.push_back({name, {}, {}, {}});
      images.back().problem = error.what();
    }
  }
  if (images.empty()) throw Error(path + ": no group of it holds keypoints, as hloc's features do");
  return images;
}

std::string WholeText(double value) {
  return std::abs(value) < 1e15 ? std::to_string(static_cast<long long>(value)) : "a value of matches0";
}

// Which images the name of a pair's group means.
class PairNameReader {
 public:
  PairNameReader(const std::vector<HlocImage>& images, const std::string& features) : features_(features) {
    for (std::size_t i = 0; i < images.size(); ++i) {
      std::string name = images[i].name;
      std::replace(name.begin(), name.end(), '/', '-');
      const auto [other, is_new] = index_.emplace(name, i);
      if (!is_new)
        throw Error(features + ": the names '" + images[other->second].name + "' and '" + images[i].name +
                    "' are the same in pairs");
    }
  }

  std::pair<std::size_t, std::size_t> Read(const std::string& group, const std::string& place) const {
    const std::size_t slash = group.find('/');
    if (slash != std::string::npos && group.find('/', slash + 1) != std::string::npos)
      throw Error(place + ": expected NAME1/NAME2 as the name of a pair");
    if (slash != std::string::npos)
      return {Index(group.substr(0, slash), place), Index(group.substr(slash + 1), place)};
    return ReadOld(group, place);
  }

 private:
  std::size_t Index(const std::string& name, const std::string& place) const {
    const auto found = index_.find(name);
    if (found == index_.end()) throw Error(place + ": " + features_ + " has no image " + name);
    return found->second;
  }

  // NAME1_NAME2, where names may have '_' themselves.
  std::pair<std::size_t, std::size_t> ReadOld(const std::string& group, const std::string& place) const {
    std::vector<std::pair<std::size_t, std::size_t>> found;
    for (std::size_t at = group.find('_'); at != std::string::npos; at = group.find('_', at + 1)) {
      const auto first = index_.find(group.substr(0, at)), second = index_.find(group.substr(at + 1));
      if (first != index_.end() && second != index_.end()) found.emplace_back(first->second, second->second);
    }
    if (found.size() != 1)
      throw Error(place + (found.empty()
                               ? ": " + features_ + " has no two images of this name, NAME1/NAME2 or NAME1_NAME2"
                               : ": can be the name of several pairs"));
    return found[0];
  }

  std::string features_;
  std::map<std::string, std::size_t> index_;
};

void ReadMatches(const GroupFile& file, const std::vector<HlocImage>& images, HlocPair* pair) {
  const std::string place = file.Place(pair->group, "matches0"),
                    score_place = file.Place(pair->group, "matching_scores0");
  const Numbers partners = *file.Read(pair->group, "matches0");
  const std::optional<Numbers> scores = file.Read(pair->group, "matching_scores0");
  const auto count1 = static_cast<std::size_t>(images[pair->image1].keypoints.rows());
  const auto count2 = static_cast<double>(images[pair->image2].keypoints.rows());
  if (partners.values.size() != count1)
    throw Error(place + ": expected " + std::to_string(count1) + " values, one a keypoint of " +
                images[pair->image1].name + ", found " + ShapeText(partners));
  if (scores && scores->values.size() != count1)
    throw Error(score_place + ": expected " + std::to_string(count1) + " values, found " + ShapeText(*scores));
  pair->matches.resize(static_cast<Eigen::Index>(count1), 2);
  if (scores) pair->scores.resize(static_cast<Eigen::Index>(count1));
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < count1; ++i) {
    const double partner = partners.values[i];
    if (partner == -1.0) continue;
    if (!(partner >= 0.0 && partner < count2))
      throw Error(place + ": " + WholeText(partner) + " is no keypoint of " + images[pair->image2].name +
                  ", which has " + std::to_string(images[pair->image2].keypoints.rows()));
    if (scores) {
      if (!(scores->values[i] >= 0.0 && scores->values[i] <= 1.0))
        throw Error(score_place + ": expected scores from 0 to 1");
      pair->scores[count] = scores->values[i];
    }
    pair->matches.row(count++) << static_cast<std::int32_t>(i), static_cast<std::int32_t>(partner);
  }
  pair->matches.conservativeResize(count, 2);
  if (scores) pair->scores.conservativeResize(count);
}

}  // namespace

HlocFiles ReadHlocFiles(const std::string& features, const std::string& matches) {
  const std::lock_guard lock(Hdf5Mutex());
  HlocFiles files;
  files.images = ReadImages(features);
  const PairNameReader names(files.images, features);
  const GroupFile file(matches);
  std::set<std::pair<std::size_t, std::size_t>> seen;
  for (const std::string& group : file.GroupsWith("matches0")) {
    HlocPair pair{group, 0, 0, {}, {}};
    try {
      std::tie(pair.image1, pair.image2) = names.Read(group, matches + ": " + group);
    } catch (const Error& error) {
      files.bad_pairs.push_back(error.what());
      continue;
    }
    if (!files.images[pair.image1].problem.empty() || !files.images[pair.image2].problem.empty()) {
      ++files.of_bad_images;
      continue;
    }
    if (!seen.insert(std::minmax(pair.image1, pair.image2)).second) {
      ++files.repeated;
      continue;
    }
    try {
      ReadMatches(file, files.images, &pair);
      files.pairs.push_back(std::move(pair));
    } catch (const Error& error) {
      files.bad_pairs.push_back(error.what());
    }
  }
  if (!files.pairs.empty()) return files;
  for (const HlocImage& image : files.images)
    if (!image.problem.empty()) throw Error(image.problem);
  if (!files.bad_pairs.empty()) throw Error(files.bad_pairs.front());
  throw Error(matches + ": no group of it holds matches0, as hloc's matches do");
}

HlocKind KindOfHlocFile(const std::string& path) {
  const std::lock_guard lock(Hdf5Mutex());
  const GroupFile file(path);
  if (!file.GroupsWith("matches0").empty()) return HlocKind::kMatches;
  return file.GroupsWith("keypoints").empty() ? HlocKind::kNeither : HlocKind::kFeatures;
}

namespace {

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
