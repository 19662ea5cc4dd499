#include <H5Cpp.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/data/point_files.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_input.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

PointMatrix ToPoints(const Numbers& numbers, const std::string& place) {
  if (numbers.shape.size() != 2 || numbers.shape[1] < 2 || numbers.shape[1] > 3)
    throw Error(place + ": expected a point set Nx2 or Nx3, found " + ShapeText(numbers));
  return Eigen::Map<const PointMatrix>(numbers.values.data(), static_cast<Eigen::Index>(numbers.shape[0]),
                                       static_cast<Eigen::Index>(numbers.shape[1]));
}

// What may stand beside the points: a data set of the group, or an attribute of the group or data set.
class Companions {
 public:
  Companions(const H5::H5Object& object, const H5::Group* group, std::string place)
      : object_(object), group_(group), place_(std::move(place)) {}

  bool Read(const char* name, Numbers* numbers) const {
    const std::string place = place_ + "/" + name;
    if (group_ != nullptr && group_->nameExists(name)) {
      *numbers = ReadNumbers(group_->openDataSet(name), place);
    } else if (object_.attrExists(name)) {
      *numbers = ReadNumbers(object_.openAttribute(name), place);
    } else {
      return false;
    }
    return true;
  }

  void ReadText(const char* name, std::string* text) const {
    if (!object_.attrExists(name)) return;
    *text = diffsac::ReadText(object_.openAttribute(name), place_ + "/" + name);
  }

  const std::string& place() const { return place_; }

 private:
  const H5::H5Object& object_;
  const H5::Group* group_;
  std::string place_;
};

ModelParameters ToModel(const Numbers& numbers, Eigen::Index dimension, const std::string& place) {
  const auto size = static_cast<Eigen::Index>(numbers.values.size());
  if (size != dimension + 1)
    throw Error(place + "/model: expected " + std::to_string(dimension + 1) + " numbers, found " +
                std::to_string(size));
  const Eigen::Map<const Eigen::VectorXd> raw(numbers.values.data(), size);
  const double length = raw.head(dimension).norm();
  if (!raw.allFinite() || !(length > 0.0)) throw Error(place + "/model: the normal must be finite and not zero");
  // A model that is already normalised stays as it is, bit for bit.
  return std::abs(length - 1.0) < 1e-12 ? ModelParameters(raw) : ModelParameters(raw / length);
}

void ReadCompanions(const Companions& companions, PointSet* set) {
  Numbers numbers;
  const std::string& place = companions.place();
  if (companions.Read("model", &numbers)) set->truth.model = ToModel(numbers, set->points.cols(), place);
  if (companions.Read("inliers", &numbers)) {
    if (static_cast<Eigen::Index>(numbers.values.size()) != set->points.rows())
      throw Error(place + "/inliers: expected " + std::to_string(set->points.rows()) + " values, one a point, found " +
                  std::to_string(numbers.values.size()));
    for (double value : numbers.values) set->truth.inliers.push_back(value != 0.0);
  }
  if (companions.Read("inlier_threshold", &numbers)) {
    if (numbers.values.size() != 1 || !(numbers.values[0] > 0.0))
      throw Error(place + "/inlier_threshold: expected one positive number");
    set->inlier_threshold = numbers.values[0];
  }
  companions.ReadText("id", &set->name);
  companions.ReadText("scene", &set->scene);
}

PointSet ReadSet(const H5::H5File& file, const std::string& key, const std::string& path) {
  const std::string place = path + ": " + key;
  PointSet set;
  set.name = std::filesystem::path(path).filename().string() + ":" + key;
  set.scene = std::filesystem::path(path).stem().string();
  const H5O_type_t kind = file.childObjType(key);
  if (kind == H5O_TYPE_DATASET) {
    const H5::DataSet data = file.openDataSet(key);
    set.points = ToPoints(ReadNumbers(data, place), place);
    ReadCompanions(Companions(data, nullptr, place), &set);
  } else if (kind == H5O_TYPE_GROUP) {
    const H5::Group group = file.openGroup(key);
    if (!group.nameExists("points")) throw Error(place + ": a group without a data set 'points'");
    set.points = ToPoints(ReadNumbers(group.openDataSet("points"), place + "/points"), place + "/points");
    ReadCompanions(Companions(group, &group, place), &set);
  } else {
    throw Error(place + ": expected a data set or a group");
  }
  return set;
}

}  // namespace

std::vector<PointSet> ReadHdf5Points(const std::string& path) {
  const std::lock_guard lock(Hdf5Mutex());
  std::string place = path;
  return WithClearErrors(place, [&] {
    if (!std::filesystem::exists(path)) throw Error(path + ": no such file");
    const H5::H5File file = OpenHdf5(path);
    std::vector<PointSet> sets;
    for (hsize_t i = 0; i < file.getNumObjs(); ++i) {
      const std::string key = file.getObjnameByIdx(i);
      place = path + ": " + key;
      sets.push_back(ReadSet(file, key, path));
    }
    return sets;
  });
}

}  // namespace diffsac
