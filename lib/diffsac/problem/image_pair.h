#pragma once

#include <Eigen/Core>

namespace diffsac {

/// N descriptors, one a row.
using DescriptorMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Width and height in pixels; 0 when unknown.
struct ImageSize {
  int width = 0;   ///< In pixels.
  int height = 0;  ///< In pixels.
  /// Both are equal.
  bool operator==(const ImageSize&) const = default;
  /// Whether there is a size.
  bool known() const { return width > 0 && height > 0; }
};

}  // namespace diffsac
