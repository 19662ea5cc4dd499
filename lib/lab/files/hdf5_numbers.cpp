#include "lab/files/hdf5_numbers.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <mutex>

#include "diffsac/core/status.h"
#include "lab/files/files.h"

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

namespace {

namespace output_driver {

/// The library's view of a file, which begins with its own part.
struct DriverFile {
  H5FD_t base{};
  int descriptor = -1;
  haddr_t end_of_addresses = 0;
  int* error = nullptr;
};

DriverFile* Of(H5FD_t* file) { return reinterpret_cast<DriverFile*>(file); }
const DriverFile* Of(const H5FD_t* file) { return reinterpret_cast<const DriverFile*>(file); }

void Keep(int error, DriverFile* file) {
  if (*file->error == 0) *file->error = error;
}

H5FD_t* Open(const char* name, unsigned flags, hid_t access, haddr_t) {
  int mode = O_RDWR | O_CLOEXEC;
  if ((flags & H5F_ACC_CREAT) != 0) mode |= O_CREAT;
  if ((flags & H5F_ACC_TRUNC) != 0) mode |= O_TRUNC;
  if ((flags & H5F_ACC_EXCL) != 0) mode |= O_EXCL;
  const int descriptor = ::open(name, mode, 0666);
  if (descriptor < 0) return nullptr;
  auto* file = new DriverFile;
  file->descriptor = descriptor;
  std::memcpy(&file->error, H5Pget_driver_info(access), sizeof file->error);
  return &file->base;
}

herr_t Close(H5FD_t* file) {
  if (::close(Of(file)->descriptor) != 0) Keep(errno, Of(file));
  delete Of(file);
  return 0;
}

herr_t Query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t EndOfAddresses(const H5FD_t* file, H5FD_mem_t) { return Of(file)->end_of_addresses; }

herr_t SetEndOfAddresses(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  Of(file)->end_of_addresses = end;
  return 0;
}

haddr_t EndOfFile(const H5FD_t* file, H5FD_mem_t) {
  struct stat info;
  return ::fstat(Of(file)->descriptor, &info) == 0 ? static_cast<haddr_t>(info.st_size) : 0;
}

/// Zeros behind the end of the file.
herr_t Read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, void* buffer) {
  auto* to = static_cast<char*>(buffer);
  while (size > 0) {
    const ssize_t count = ::pread(Of(file)->descriptor, to, size, static_cast<off_t>(address));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) Keep(errno, Of(file));
    if (count <= 0) break;
    to += count, address += static_cast<haddr_t>(count), size -= static_cast<std::size_t>(count);
  }
  std::fill_n(to, size, '\0');
  return 0;
}

herr_t Write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, const void* buffer) {
  const auto* from = static_cast<const char*>(buffer);
  while (size > 0) {
    const ssize_t count = ::pwrite(Of(file)->descriptor, from, size, static_cast<off_t>(address));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      Keep(errno, Of(file));
      break;
    }
    from += count, address += static_cast<haddr_t>(count), size -= static_cast<std::size_t>(count);
  }
  return 0;
}

herr_t Truncate(H5FD_t* file, hid_t, hbool_t) {
  const auto end = static_cast<off_t>(Of(file)->end_of_addresses);
  if (EndOfFile(file, H5FD_MEM_DEFAULT) != Of(file)->end_of_addresses && ::ftruncate(Of(file)->descriptor, end) != 0)
    Keep(errno, Of(file));
  return 0;
}

}  // namespace output_driver

H5FD_class_t MakeDriver() {
  H5FD_class_t driver{};
#if H5_VERSION_GE(1, 13, 0)
  driver.version = H5FD_CLASS_VERSION;
  driver.value = static_cast<H5FD_class_value_t>(511);  // The last of those that anybody may use.
#endif
  driver.name = "diffsac_output";
  driver.maxaddr = (static_cast<haddr_t>(1) << (8 * sizeof(off_t) - 1)) - 1;
  driver.fc_degree = H5F_CLOSE_WEAK;
  driver.fapl_size = sizeof(int*);
  driver.open = output_driver::Open;
  driver.close = output_driver::Close;
  driver.query = output_driver::Query;
  driver.get_eoa = output_driver::EndOfAddresses;
  driver.set_eoa = output_driver::SetEndOfAddresses;
  driver.get_eof = output_driver::EndOfFile;
  driver.read = output_driver::Read;
  driver.write = output_driver::Write;
  driver.truncate = output_driver::Truncate;
  constexpr H5FD_mem_t kMap[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(kMap), std::end(kMap), driver.fl_map);
  return driver;
}

H5::FileAccPropList Access(int* error) {
  static const H5FD_class_t driver = MakeDriver();
  static const hid_t registered = H5FDregister(&driver);
  H5::FileAccPropList access;
  access.setDriver(registered, &error);
  return access;
}

}  // namespace

Hdf5Output::Hdf5Output(const std::string& file, const std::string& path)
    : path_(path), error_(std::make_unique<int>(0)) {
  const std::lock_guard lock(Hdf5Mutex());
  errno = 0;
  try {
    file_ = std::make_unique<H5::H5File>(file, H5F_ACC_TRUNC, H5::FileCreatPropList::DEFAULT, Access(error_.get()));
  } catch (const H5::Exception& e) {
    Fail(errno != 0 ? std::strerror(errno) : Describe(e));
  }
}

Hdf5Output::~Hdf5Output() {
  const std::lock_guard lock(Hdf5Mutex());
  file_.reset();
}

void Hdf5Output::Use(const std::function<void(H5::H5File&)>& write) {
  const std::lock_guard lock(Hdf5Mutex());
  try {
    write(*file_);
  } catch (const H5::Exception& e) {
    CheckWritten();
    Fail(Describe(e));
  }
  CheckWritten();
}

void Hdf5Output::Close() {
  Use([](H5::H5File& file) { file.close(); });
}

void Hdf5Output::CheckWritten() const {
  if (*error_ != 0) Fail(std::strerror(*error_));
}

void Hdf5Output::Fail(const std::string& cause) const { throw Error("cannot write '" + path_ + "': " + cause); }

void WriteHdf5(const std::string& path, const std::function<void(Hdf5Output&)>& fill) {
  WriteFileAtomically(path, [&](const std::string& temporary) {
    Hdf5Output output(temporary, path);
    fill(output);
    output.Close();
  });
}

}  // namespace diffsac
