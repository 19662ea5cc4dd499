#pragma once

#include <Eigen/Core>
#include <cmath>

#include "diffsac/core/random.h"
#include "diffsac/geometry/points.h"

namespace diffsac::testing {

/// `count` segments of lengths .05 to .2 in [−1, 1]², whose lines pass through the vanishing point but for an angle of
/// this standard deviation (radians).
inline PointMatrix SegmentsTowards(const Eigen::Vector3d& v, int count, double noise, Rng rng) {
  PointMatrix segments(count, 4);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d middle(rng.Uniform(-1.0, 1.0), rng.Uniform(-1.0, 1.0));
    const Eigen::Vector2d towards = v.head<2>() - v[2] * middle;
    const double angle = std::atan2(towards[1], towards[0]) + noise * rng.Normal();
    const Eigen::Vector2d half = 0.5 * rng.Uniform(0.05, 0.2) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    segments.row(i) << (middle - half).transpose(), (middle + half).transpose();
  }
  return segments;
}

/// Segments of any direction.
inline PointMatrix RandomSegments(int count, Rng rng) {
  PointMatrix segments(count, 4);
  for (int i = 0; i < count; ++i) {
    const double x = rng.Uniform(-1.0, 1.0), y = rng.Uniform(-1.0, 1.0), angle = rng.Uniform(0.0, 3.14159265);
    segments.row(i) << x, y, x + 0.1 * std::cos(angle), y + 0.1 * std::sin(angle);
  }
  return segments;
}

inline PointMatrix Stacked(const PointMatrix& first, const PointMatrix& second) {
  PointMatrix both(first.rows() + second.rows(), 4);
  both << first, second;
  return both;
}

}  // namespace diffsac::testing
