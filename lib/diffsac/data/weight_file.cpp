#include "diffsac/data/weight_file.h"

#include <H5Cpp.h>

#include <filesystem>
#include <functional>
#include <mutex>

#include "diffsac/core/status.h"
#include "diffsac/data/hdf5_numbers.h"

namespace diffsac {
namespace {

// What `read` says of an open file; HDF5's own errors as ours.
void ReadHdf5(const std::string& path, const std::function<void(const H5::H5File&)>& read) {
  if (!std::filesystem::is_regular_file(path)) throw Error(path + ": no such file of weights");
  const std::scoped_lock lock(Hdf5Mutex());
  H5::Exception::dontPrint();
  try {
    read(H5::H5File(path, H5F_ACC_RDONLY));
  } catch (const H5::Exception& e) {
    throw Error(path + ": not a readable file of weights, " + Describe(e));
  }
}

std::string ReadText(const H5::H5File& file, const char* name, const std::string& path) {
  if (!file.attrExists(name))
    throw Error(path + ": no attribute '" + name + "'; expected weights as scripts/peers/ write them");
  const H5::Attribute attribute = file.openAttribute(name);
  if (attribute.getTypeClass() != H5T_STRING) throw Error(path + ": attribute '" + name + "': expected a string");
  std::string text;
  attribute.read(attribute.getStrType(), text);
  return text;
}

WeightArray ReadArray(const H5::Group& group, const std::string& name, const std::string& place) {
  if (group.childObjType(name) != H5O_TYPE_DATASET) throw Error(place + ": expected an array");
  const H5::DataSet data = group.openDataSet(name);
  if (data.getTypeClass() != H5T_FLOAT || data.getFloatType().getSize() != sizeof(float))
    throw Error(place + ": expected 32-bit floats");
  const Numbers numbers = ReadNumbers(data, place);
  return {{numbers.shape.begin(), numbers.shape.end()}, {numbers.values.begin(), numbers.values.end()}};
}

std::map<std::string, WeightArray> ReadArrays(const H5::H5File& file, const std::string& name,
                                              const std::string& path) {
  if (!file.nameExists(name)) throw Error(path + ": no group '" + name + "'");
  const H5::Group group = file.openGroup(name);
  std::map<std::string, WeightArray> arrays;
  for (hsize_t i = 0; i < group.getNumObjs(); ++i) {
    const std::string key = group.getObjnameByIdx(i);
    arrays[key] = ReadArray(group, key, path + ": " + name + "/" + key);
  }
  return arrays;
}

}  // namespace

WeightFile ReadWeightFile(const std::string& path) {
  WeightFile result;
  ReadHdf5(path, [&](const H5::H5File& file) {
    result.method = ReadText(file, "method", path);
    result.task = ReadText(file, "task", path);
    result.weights = ReadArrays(file, "weights", path);
  });
  return result;
}

std::map<std::string, WeightArray> ReadWeightArrays(const std::string& path, const std::string& group) {
  std::map<std::string, WeightArray> arrays;
  ReadHdf5(path, [&](const H5::H5File& file) { arrays = ReadArrays(file, group, path); });
  return arrays;
}

}  // namespace diffsac
