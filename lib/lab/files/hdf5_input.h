#pragma once

#include <H5Cpp.h>

#include <string>

namespace diffsac {

/// Opens a file of anybody's for reading; callers hold Hdf5Mutex. Bytes that no HDF5 library wrote can crash the
/// library itself. So what this process has not seen before (device, inode, size and times) is first read by a child of
/// it: all names, attributes and values that our readers would ask for. Throws Error naming the file when the child
/// crashes or uses more time than such a file can need; H5::Exception as H5::H5File does.
H5::H5File OpenHdf5(const std::string& path);

/// The same for the bytes of a file, which outlive it; `name` stands for it in messages.
H5::H5File OpenHdf5Bytes(const std::string& bytes, const std::string& name);

}  // namespace diffsac
