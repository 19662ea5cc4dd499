#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace diffsac {

/// An array of 32-bit floats, row-major.
struct WeightArray {
  std::vector<std::int64_t> shape;
  std::vector<float> values;
};

/// Weights of a network that another program trained, as scripts/peers/ convert them: an HDF5 file with the attributes
/// `method` and `task` that say what they are for, and a data set of 32-bit floats for each in the group `weights`.
struct WeightFile {
  std::string method, task;
  std::map<std::string, WeightArray> weights;
};

/// Throws Error naming the file: missing, of another kind, a weight that is not of 32-bit floats.
WeightFile ReadWeightFile(const std::string& path);

/// The arrays of a group of such a file. Throws Error.
std::map<std::string, WeightArray> ReadWeightArrays(const std::string& path, const std::string& group);

}  // namespace diffsac
