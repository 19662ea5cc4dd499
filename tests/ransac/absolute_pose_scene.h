#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/absolute_pose.h"

namespace diffsac::testing {

/// Points X Y Z u v in normalised coordinates, the outliers first.
struct AbsolutePoseScene {
  PointMatrix points;
  std::vector<std::uint8_t> inliers;
  AbsolutePose::Parameters truth;
};

/// A box of sides 4, 4 and `depth` seen from about 6 away; σ in normalised coordinates.
inline AbsolutePoseScene MakeAbsolutePoseScene(int count, double outlier_ratio, double noise, Rng rng,
                                               double depth = 4.0) {
  const Eigen::Matrix3d rotation =
      Eigen::Quaterniond(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal()).normalized().toRotationMatrix();
  const Eigen::Vector3d translation(rng.Normal(), rng.Normal(), 6.0);
  AbsolutePoseScene scene{PointMatrix(count, 5), std::vector<std::uint8_t>(count, 1), PoseOf(rotation, translation)};
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d x(rng.Uniform(-2.0, 2.0), rng.Uniform(-2.0, 2.0), 0.5 * depth * rng.Uniform(-1.0, 1.0));
    const Eigen::Vector3d camera = rotation * x + translation;
    Eigen::Vector2d image = camera.head<2>() / camera[2] + noise * Eigen::Vector2d(rng.Normal(), rng.Normal());
    if (i < outlier_ratio * count) {
      image = Eigen::Vector2d(rng.Uniform(-0.7, 0.7), rng.Uniform(-0.7, 0.7));
      scene.inliers[i] = 0;
    }
    scene.points.row(i) << x.transpose(), image.transpose();
  }
  return scene;
}

}  // namespace diffsac::testing
