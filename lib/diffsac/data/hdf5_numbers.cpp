#include "diffsac/data/hdf5_numbers.h"

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

void ReadInto(const H5::DataSet& source, double* out) { source.read(out, H5::PredType::NATIVE_DOUBLE); }
void ReadInto(const H5::Attribute& source, double* out) { source.read(H5::PredType::NATIVE_DOUBLE, out); }

template <class Source>
Numbers Read(const Source& source, const std::string& place) {
  const H5T_class_t kind = source.getTypeClass();
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) throw Error(place + ": expected numbers");
  const H5::DataSpace space = source.getSpace();
  Numbers numbers;
  const int rank = space.getSimpleExtentNdims();
  numbers.shape.resize(rank);
  if (rank > 0) space.getSimpleExtentDims(numbers.shape.data());
  numbers.values.resize(static_cast<std::size_t>(space.getSimpleExtentNpoints()));
  if (!numbers.values.empty()) ReadInto(source, numbers.values.data());
  return numbers;
}

}  // namespace

std::mutex& Hdf5Mutex() {
  static std::mutex mutex;
  return mutex;
}

Numbers ReadNumbers(const H5::DataSet& source, const std::string& place) { return Read(source, place); }
Numbers ReadNumbers(const H5::Attribute& source, const std::string& place) { return Read(source, place); }

void WriteNumbers(const H5::Group& group, const char* name, const double* values, const std::vector<hsize_t>& shape) {
  const H5::DataSpace space(static_cast<int>(shape.size()), shape.data());
  const H5::DataSet data = group.createDataSet(name, H5::PredType::IEEE_F64LE, space, WithoutTimes());
  if (space.getSimpleExtentNpoints() > 0) data.write(values, H5::PredType::NATIVE_DOUBLE);
}

H5::DSetCreatPropList WithoutTimes() {
  H5::DSetCreatPropList properties;
  H5Pset_obj_track_times(properties.getId(), false);
  return properties;
}

std::string ShapeText(const Numbers& numbers) {
  std::string text;
  for (hsize_t size : numbers.shape) text += (text.empty() ? "" : "x") + std::to_string(size);
  return text.empty() ? "a single number" : text;
}

std::string Describe(const H5::Exception& e) { return "HDF5: " + e.getDetailMsg() + " (" + e.getFuncName() + ")"; }

}  // namespace diffsac
