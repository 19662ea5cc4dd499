#include "lab/files/hdf5_numbers.h"

#include <algorithm>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

// Whatever a file's size is: so much can be empty space that was never written.
constexpr hsize_t kAlwaysValues = 1 << 20;
constexpr hsize_t kAlwaysChunk = hsize_t{64} << 20;  // bytes
// 800 MB as doubles; descriptors of 100 000 matches are a quarter of it.
constexpr hsize_t kMostValues = 100'000'000;
// What deflate makes of equal bytes.
constexpr hsize_t kDensest = 1032;

hsize_t FileSize(hid_t data_set) {
  const hid_t file = H5Iget_file_id(data_set);
  hsize_t size = 0;
  const bool known = file >= 0 && H5Fget_filesize(file, &size) >= 0;
  if (file >= 0) H5Fclose(file);
  return known ? size : 0;
}

// Bytes of one chunk; 0 for other layouts.
hsize_t ChunkSize(hid_t properties, hsize_t value_size) {
  if (H5Pget_layout(properties) != H5D_CHUNKED) return 0;
  hsize_t sizes[H5S_MAX_RANK], bytes = value_size;
  const int rank = H5Pget_chunk(properties, H5S_MAX_RANK, sizes);
  for (int i = 0; i < rank; ++i)
    if (__builtin_mul_overflow(bytes, sizes[i], &bytes)) return ~hsize_t{0};
  return bytes;
}

const char* WhyRefused(hid_t properties, hssize_t claimed, hsize_t value_size, hsize_t file_size) {
  if (H5Pget_external_count(properties) > 0 || H5Pget_layout(properties) == H5D_VIRTUAL)
    return ": its values lie in other files, which are not read";
  const auto count = static_cast<hsize_t>(claimed);
  const hsize_t room = std::min(file_size, kMostValues * value_size) * kDensest;  // bytes, when uncompressed
  if (claimed < 0 || (count > kAlwaysValues && count > std::min(kMostValues, room / value_size)))
    return ": damaged, or too large: it claims more values than its file can hold, or than are read";
  if (ChunkSize(properties, value_size) > std::max(kAlwaysChunk, std::min(room, kMostValues * 8)))
    return ": damaged: it claims chunks larger than its file can hold";
  return nullptr;
}

}  // namespace

std::mutex& Hdf5Mutex() {
  static std::mutex mutex;
  // Links into other files: none of ours has them, and a strange file must not open others. Where one leads to no HDF5
  // file, version 1.10 of the library crashes when the program ends.
  static const herr_t no_external_links = H5Lunregister(H5L_TYPE_EXTERNAL);
  static const bool silent = (H5::Exception::dontPrint(), true);
  static_cast<void>(no_external_links), static_cast<void>(silent);
  return mutex;
}

static const char* WhyRefused(hid_t data_set, hsize_t* count) {
  const hid_t properties = H5Dget_create_plist(data_set), space = H5Dget_space(data_set), type = H5Dget_type(data_set);
  const bool known = properties >= 0 && space >= 0 && type >= 0;
  const hssize_t claimed = known ? H5Sget_simple_extent_npoints(space) : 0;
  *count = static_cast<hsize_t>(claimed);
  const char* why = known ? WhyRefused(properties, claimed, std::max<hsize_t>(H5Tget_size(type), 1), FileSize(data_set))
                          : ": damaged or truncated: its shape, type or layout cannot be read";
  if (type >= 0) H5Tclose(type);
  if (space >= 0) H5Sclose(space);
  if (properties >= 0) H5Pclose(properties);
  return why;
}

Numbers ReadNumbers(const H5::DataSet& source, const std::string& place) {
  const H5T_class_t kind = source.getTypeClass();
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) throw Error(place + ": expected numbers");
  const H5::DataSpace space = source.getSpace();
  Numbers numbers;
  hsize_t count = 0;
  if (const char* why = WhyRefused(source.getId(), &count)) throw Error(place + why);
  const int rank = space.getSimpleExtentNdims();
  numbers.shape.resize(rank);
  if (rank > 0) space.getSimpleExtentDims(numbers.shape.data());
  numbers.values.resize(static_cast<std::size_t>(count));
  if (!numbers.values.empty()) source.read(numbers.values.data(), H5::PredType::NATIVE_DOUBLE);
  return numbers;
}

Numbers ReadNumbersOfShape(const H5::Group& group, const std::string& name, const std::vector<hsize_t>& shape,
                           const std::string& place) {
  const std::string where = place + "/" + name;
  if (!group.nameExists(name)) throw Error(where + ": there is no such data set");
  Numbers numbers = ReadNumbers(group.openDataSet(name), where);
  bool fits = numbers.shape.size() == shape.size();
  for (std::size_t i = 0; fits && i < shape.size(); ++i) fits = shape[i] == 0 || numbers.shape[i] == shape[i];
  if (fits) return numbers;
  std::string expected;
  for (const hsize_t size : shape) expected += (expected.empty() ? "" : "x") + (size == 0 ? "N" : std::to_string(size));
  throw Error(where + ": found " + ShapeText(numbers) + ", expected " + expected + " numbers");
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
