#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/geometry/essential.h"
#include "geometry/two_view_problems.h"

namespace diffsac::testing {

/// Two views of a scene that is mostly one plane.
struct PlanarScene {
  TwoViewProblem views;
  std::vector<int> kind;         ///< 1: on the plane, 2: off it, 0: outlier
  Matrix3Parameters homography;  ///< of the plane, in pixels
};

/// `count` correspondences: `outliers` of them uniform in both images, and of the others `on_plane` on a plane about 6
/// baselines away, the rest at depths 2 to 10; noise in pixels on every coordinate.
inline PlanarScene MakePlanarScene(int count, double on_plane, double outliers, double noise, Rng& rng) {
  PlanarScene scene;
  TwoViewProblem& views = scene.views;
  views = RandomProblem(0, rng);
  const Eigen::Vector3d normal = Eigen::Vector3d(rng.Uniform(-0.7, 0.7), rng.Uniform(-0.7, 0.7), 1.0).normalized();
  const double distance = normal.dot(Eigen::Vector3d(0.0, 0.0, 6.0));
  scene.homography = AsParameters(
      views.k2 * (views.pose.rotation + views.pose.translation * normal.transpose() / distance) * views.k1.inverse());
  const int bad = static_cast<int>(std::lround(outliers * count));
  const int flat = static_cast<int>(std::lround(on_plane * (count - bad)));
  views.pixels.resize(count, 4);
  scene.kind.resize(count);
  const std::vector<int> rows = rng.Permutation(count);
  for (int i = 0; i < count;) {
    const int row = rows[i], kind = i < bad ? 0 : i < bad + flat ? 1 : 2;
    if (kind == 0) {
      for (int j = 0; j < 4; ++j) views.pixels(row, j) = rng.Uniform(0.0, 1000.0);
    } else {
      Eigen::Vector3d first(rng.Uniform(-0.6, 0.6), rng.Uniform(-0.6, 0.6), 1.0);
      first *= kind == 1 ? distance / normal.dot(first) : rng.Uniform(2.0, 10.0);
      const Eigen::Vector3d second = views.pose.rotation * first + views.pose.translation;
      if (first[2] < 0.5 || second[2] < 0.5 || first[2] > 100.0) continue;
      views.pixels.row(row) << (views.k1 * first).hnormalized().transpose(),
          (views.k2 * second).hnormalized().transpose();
      for (int j = 0; j < 4; ++j) views.pixels(row, j) += noise * rng.Normal();
    }
    scene.kind[row] = kind;
    ++i;
  }
  views.normalized = NormalizedCoordinates(views.pixels, views.k1, views.k2);
  return scene;
}

/// Largest of the errors of rotation and of translation's direction, in degrees; 180 where no pose can be had.
inline double PoseErrorDegrees(const TwoViewProblem& views, const Matrix3Parameters& fundamental,
                               const std::vector<std::uint8_t>& inliers) {
  const Eigen::Matrix3d e = ClosestEssential(EssentialFromFundamental(AsMatrix(fundamental), views.k1, views.k2));
  const PoseChoice choice = ChoosePose(e, views.normalized, inliers);
  if (choice.status != Status::kOk) return 180.0;
  const double rotation = RotationAngleDegrees(choice.pose.rotation, views.pose.rotation);
  return std::max(rotation, DirectionAngleDegrees(choice.pose.translation, views.pose.translation));
}

}  // namespace diffsac::testing
