#include "lab/files/hdf5_output.h"

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
