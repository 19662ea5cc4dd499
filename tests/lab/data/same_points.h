#pragma once

#include "diffsac/problem/problem.h"

namespace diffsac::testing {

/// Eigen compares only what is of the same size.
inline bool SamePoints(const PointMatrix& a, const PointMatrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && a == b;
}

}  // namespace diffsac::testing
