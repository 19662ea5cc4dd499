#pragma once

#include <H5Cpp.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lab/files/hdf5_numbers.h"

namespace diffsac {

/// A new HDF5 file. The library does not survive a disk that fills: its destructors fail, and it crashes when the
/// program ends. So what it writes goes through a driver that keeps the first error, for us, and tells the library that
/// all went well. Every call holds the library's lock itself.
class Hdf5Output {
 public:
  /// `path` is the name for messages. Throws Error when it cannot be created.
  Hdf5Output(const std::string& file, const std::string& path);
  ~Hdf5Output();
  Hdf5Output(const Hdf5Output&) = delete;
  Hdf5Output& operator=(const Hdf5Output&) = delete;

  /// Calls `write`, which calls the library. Throws Error when what was written so far is not on the disk.
  void Use(const std::function<void(H5::H5File&)>& write);

  /// A data set that does not say when it was made: the same content is the same file. Throws as Use does.
  template <class Value>
  void Put(const std::string& name, const Value* values, const std::vector<hsize_t>& shape) {
    Use([&](H5::H5File& file) { WriteNumbers(file, name, values, shape); });
  }

  /// Throws Error when the file is not whole.
  void Close();

 private:
  void CheckWritten() const;
  [[noreturn]] void Fail(const std::string& cause) const;

  std::string path_;
  std::unique_ptr<int> error_;  // The errno of the first call that failed; in one place while the driver knows it.
  std::unique_ptr<H5::H5File> file_;
};

/// The file with what `fill` puts into it, whole or not at all.
void WriteHdf5(const std::string& path, const std::function<void(Hdf5Output&)>& fill);

}  // namespace diffsac
