#pragma once

#include <H5Cpp.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <type_traits>
#include <vector>

#include "diffsac/core/status.h"

namespace diffsac {

/// Held by everything that calls HDF5, in every thread: the library is not thread-safe as distributions build it. The
/// first call also makes links into other files fail to open, and the library silent.
std::mutex& Hdf5Mutex();

/// Opens a file for reading; callers hold Hdf5Mutex. Throws H5::Exception for what is no HDF5 file, or a cut one.
/// Readers check sizes and types before they read values. Bytes that no HDF5 library wrote may still
/// crash the library (docs/reliability.md).
inline H5::H5File OpenHdf5(const std::string& path) { return H5::H5File(path, H5F_ACC_RDONLY); }

/// A data set, converted to double, row-major.
struct Numbers {
  std::vector<hsize_t> shape;
  std::vector<double> values;
};

/// `place` names file and object in messages. Throws Error, starting with it, when it holds no numbers, and for what
/// only a damaged or hostile file asks for: more values, or larger chunks, than a file of its size can hold, and values
/// that lie in other files; H5::Exception otherwise.
Numbers ReadNumbers(const H5::DataSet& source, const std::string& place);

/// A data set of the group that must have this shape, in which 0 stands for any number; `place` names the group. Throws
/// Error, where there is none or it has another, as ReadNumbers does else.
Numbers ReadNumbersOfShape(const H5::Group& group, const std::string& name, const std::vector<hsize_t>& shape,
                           const std::string& place);

/// How numbers lie in memory, and in the files that this machine writes.
template <class Value>
const H5::PredType& Hdf5Type() {
  if constexpr (std::is_same_v<Value, double>) return H5::PredType::NATIVE_DOUBLE;
  if constexpr (std::is_same_v<Value, float>) return H5::PredType::NATIVE_FLOAT;
  if constexpr (std::is_same_v<Value, std::int32_t>) return H5::PredType::NATIVE_INT32;
  if constexpr (std::is_same_v<Value, std::int64_t>) return H5::PredType::NATIVE_INT64;
  if constexpr (std::is_same_v<Value, std::uint64_t>) return H5::PredType::NATIVE_UINT64;
  if constexpr (sizeof(Value) == 1) return H5::PredType::NATIVE_UINT8;
}

/// How a data set is created that does not say when it was: the same content is then the same file.
H5::DSetCreatPropList WithoutTimes();

/// A data set, row-major. Throws H5::Exception.
template <class Value>
void WriteNumbers(const H5::Group& group, const std::string& name, const Value* values,
                  const std::vector<hsize_t>& shape, const H5::DSetCreatPropList& properties = WithoutTimes()) {
  const H5::DataSpace space(static_cast<int>(shape.size()), shape.data());
  const H5::DataSet data = group.createDataSet(name, Hdf5Type<Value>(), space, properties);
  if (space.getSimpleExtentNpoints() > 0) data.write(values, Hdf5Type<Value>());
}

/// "3x4", or "a single number".
std::string ShapeText(const Numbers& numbers);

/// One line about an exception of the library.
std::string Describe(const H5::Exception& e);

/// What `call`, which reads by the library, returns. What the library throws becomes an Error that starts with `place`,
/// which may be refined while it runs.
template <class Call>
auto WithClearErrors(const std::string& place, const Call& call) {
  try {
    return call();
  } catch (const H5::FileIException& e) {
    throw Error(place + ": not a readable HDF5 file, or truncated: " + Describe(e));
  } catch (const H5::Exception& e) {
    throw Error(place + ": damaged or truncated: " + Describe(e));
  } catch (const std::bad_alloc&) {
    throw Error(place + ": too large for the memory");
  }
}

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
