#pragma once

#include <H5Cpp.h>

#include <string>

namespace diffsac {

/// Opens a file for reading; callers hold Hdf5Mutex. Throws H5::Exception for what is no HDF5 file, or a cut one.
/// Readers check sizes and types before they read values (hdf5_numbers.h). Bytes that no HDF5 library wrote may still
/// crash the library (docs/reliability.md).
inline H5::H5File OpenHdf5(const std::string& path) { return H5::H5File(path, H5F_ACC_RDONLY); }

}  // namespace diffsac
