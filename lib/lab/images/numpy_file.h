#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace diffsac {

/// An array of NumPy's, converted to double, row-major.
struct NumpyArray {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};

/// A .npy file (format 1 to 3): little-endian floating-point numbers or integers, in C's or Fortran's order. Throws
/// Error that starts with the path for anything else.
NumpyArray ReadNpy(const std::string& path);

/// The content of such a file; `place` stands first in messages.
NumpyArray ParseNpy(std::string_view content, const std::string& place);

/// The arrays of a .npz file by name, without ".npy". Throws Error.
std::map<std::string, NumpyArray> ReadNpz(const std::string& path);

}  // namespace diffsac
