#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

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

/// Line segments of a room, as a camera that is pitched (up), rolled (clockwise) and turned sees them, on 640 × 480
/// pixels. Angles in radians.
struct RoomSegments {
  Eigen::Matrix3d K{{520.0, 0.0, 319.5}, {0.0, 520.0, 239.5}, {0.0, 0.0, 1.0}};
  Eigen::Matrix3d rotation;              ///< World-to-camera; the world's y axis points down.
  PointMatrix segments;                  ///< N × 4, pixels.
  std::vector<std::int32_t> directions;  ///< N values: the axis of each, 3 for none.
  Eigen::Vector3d Point(int axis) const { return K * rotation.col(axis); }

  /// count: of each axis. noise_px: of each coordinate of the ends. others: segments of any direction.
  RoomSegments(double turn, double pitch, double roll, int count, double noise_px, int others, Rng rng) {
    rotation = (Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(-pitch, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()))
                   .toRotationMatrix();
    segments.resize(3 * count + others, 4);
    int row = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < count; ++i, ++row) {
        Add(row, RandomStart(rng), rng.Uniform(0.5, 1.5) * rotation.col(axis), noise_px, rng);
        directions.push_back(axis);
      }
    for (int i = 0; i < others; ++i, ++row) {
      Add(row, RandomStart(rng), 0.4 * Eigen::Vector3d(rng.Normal(), rng.Normal(), 0.0), noise_px, rng);
      directions.push_back(3);
    }
  }

 private:
  /// Somewhere in front of the camera, in its frame.
  static Eigen::Vector3d RandomStart(Rng& rng) {
    return {rng.Uniform(-2.0, 2.0), rng.Uniform(-1.5, 1.5), rng.Uniform(4.0, 7.0)};
  }
  void Add(int row, const Eigen::Vector3d& start, const Eigen::Vector3d& along, double noise_px, Rng& rng) {
    segments.row(row) << (K * start).hnormalized().transpose(), (K * (start + along)).hnormalized().transpose();
    for (int k = 0; k < 4; ++k) segments(row, k) += noise_px * rng.Normal();
  }
};

}  // namespace diffsac::testing
