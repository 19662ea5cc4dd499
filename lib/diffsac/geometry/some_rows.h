#pragma once

#include <Eigen/Core>

namespace diffsac {

/// Rows of `count`, evenly, about `most` at most; all where there are fewer. As an index of a matrix.
inline auto SomeRows(Eigen::Index count, Eigen::Index most) {
  const Eigen::Index step = 1 + count / most;
  return Eigen::seqN(Eigen::Index{0}, (count + step - 1) / step, step);
}

}  // namespace diffsac
