#pragma once

#include "diffsac/core/random.h"
#include "diffsac/geometry/points.h"

namespace diffsac::testing {

inline PointMatrix RandomPoints(int count, int dimension, double half_width, Rng& rng) {
  PointMatrix points(count, dimension);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = rng.Uniform(-half_width, half_width);
  return points;
}

}  // namespace diffsac::testing
