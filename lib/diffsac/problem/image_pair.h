#pragma once

#include <Eigen/Core>

namespace diffsac {

/// N descriptors, one a row.
using DescriptorMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Width and height in pixels; 0 when unknown.
struct ImageSize {
  int width = 0;
  int height = 0;
  bool operator==(const ImageSize&) const = default;
  bool known() const { return width > 0 && height > 0; }
};

}  // namespace diffsac
