#pragma once

#include <Eigen/Core>
#include <cmath>

#include "diffsac/core/random.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/unknown_focal.h"
#include "geometry/two_view_problems.h"

namespace diffsac::testing {

/// Two cameras with an unknown focal length, and matches in the coordinates that UnknownFocal says.
struct UnknownFocalScene {
  RelativePose pose;
  FocalParameters model;
  PointMatrix points;
};

enum class Motion { kAny, kForward, kTurn };

/// `count` points at depths 2 to 8, or on the plane z = 4 + x/2 (`planar`), with normal noise on every coordinate.
inline UnknownFocalScene MakeUnknownFocalScene(UnknownFocal unknown, int count, Rng& rng, double noise = 0.0,
                                               Motion motion = Motion::kAny, bool planar = false) {
  UnknownFocalScene scene;
  scene.pose = RandomPose(rng, 0.4);
  if (motion == Motion::kForward) scene.pose = {Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitZ()};
  const double focal = std::exp(rng.Uniform(-0.5, 0.5)), first = unknown == UnknownFocal::kBoth ? focal : 1.0;
  scene.points.resize(count, 4);
  const Eigen::Vector3d translation =
      motion == Motion::kTurn ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : Eigen::Vector3d(scene.pose.translation);
  for (int i = 0; i < count;) {
    const double x = rng.Uniform(-0.4, 0.4), y = rng.Uniform(-0.4, 0.4);
    const double depth = planar ? 4.0 / (1.0 - 0.5 * x) : rng.Uniform(2.0, 8.0);
    const Eigen::Vector3d a = depth * Eigen::Vector3d(x, y, 1.0), b = scene.pose.rotation * a + translation;
    if (b[2] < 0.5) continue;
    scene.points.row(i) << first * a.hnormalized().transpose(), focal * b.hnormalized().transpose();
    for (int j = 0; j < 4; ++j) scene.points(i, j) += noise * rng.Normal();
    ++i;
  }
  scene.model = AsFocalParameters(AsParameters(EssentialFromPose(scene.pose)), focal);
  return scene;
}

/// Of E, whichever sign it has, and of log f.
inline double FocalModelDistance(const FocalParameters& a, const FocalParameters& b) {
  return ModelDistance(a.head<9>(), b.head<9>()) + std::abs(std::log(a[9] / b[9]));
}

}  // namespace diffsac::testing
