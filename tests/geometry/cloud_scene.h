#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/rigid.h"

namespace diffsac::testing {

/// Matches of two clouds, the wrong ones first.
struct CloudScene {
  PointMatrix points;
  std::vector<std::uint8_t> inliers;
  Rigid::Parameters truth;
};

/// A box of sides 4, 4 and `depth`, turned, moved and `scale` times as large in the second cloud; σ of each coordinate
/// there. Wrong matches are anywhere in it.
inline CloudScene MakeCloudScene(int count, double outlier_ratio, double noise, Rng rng, double scale = 1.0,
                                 double depth = 4.0) {
  const Eigen::Matrix3d rotation =
      Eigen::Quaterniond(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal()).normalized().toRotationMatrix();
  const Eigen::Vector3d translation(rng.Normal(), rng.Normal(), 3.0);
  CloudScene scene{PointMatrix(count, 6), std::vector<std::uint8_t>(count, 1), PoseOf(scale * rotation, translation)};
  const auto anywhere = [&] {
    return Eigen::Vector3d(rng.Uniform(-2.0, 2.0), rng.Uniform(-2.0, 2.0), 0.5 * depth * rng.Uniform(-1.0, 1.0));
  };
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d x = anywhere();
    scene.inliers[i] = i < std::lround(outlier_ratio * count) ? 0 : 1;
    const Eigen::Vector3d seen = scene.inliers[i] == 1 ? x : anywhere();
    const Eigen::Vector3d y = scale * (rotation * seen) + translation;
    scene.points.row(i) << x.transpose(), y[0] + noise * rng.Normal(), y[1] + noise * rng.Normal(),
        y[2] + noise * rng.Normal();
  }
  return scene;
}

}  // namespace diffsac::testing
