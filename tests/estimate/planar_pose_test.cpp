// A planar target far away: two poses show it nearly the same.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/core/random.h"
#include "diffsac/diffsac.h"
#include "diffsac/geometry/pose.h"
#include "estimate/owned_matches.h"

namespace diffsac {
namespace {

const Eigen::Matrix3d kCamera{{1500.0, 0.0, 960.0}, {0.0, 1500.0, 540.0}, {0.0, 0.0, 1.0}};

struct Target {
  testing::OwnedMatches2D3D points;
  RigidMotion pose;
  /// Whether an estimate is nearer to the other pose, whose normal is mirrored at the line of sight.
  bool Flipped(const Eigen::Matrix3d& rotation) const {
    const Eigen::Vector3d sight = pose.translation.normalized();
    const Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity() - 2.0 * sight * sight.transpose();
    const Eigen::Matrix3d other = mirror * pose.rotation * Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal();
    return RotationAngleDegrees(rotation, other) < RotationAngleDegrees(rotation, pose.rotation);
  }
};

/// grid × grid points on a square of side 1, tilted by 20 to 60 degrees; relief: their height, uniform.
Target MakeTarget(int index, int grid, double distance, double noise_px, double relief = 0.0) {
  Rng rng = Rng(7).Fork("target", index);
  const Eigen::Vector3d axis = Eigen::Vector3d(rng.Normal(), rng.Normal(), 0.0).normalized();
  Target target;
  target.pose.rotation = (Eigen::AngleAxisd(rng.Uniform(0.35, 1.05), axis) *
                          Eigen::AngleAxisd(rng.Uniform(-3.0, 3.0), Eigen::Vector3d::UnitZ()))
                             .toRotationMatrix();
  target.pose.translation = distance * Eigen::Vector3d(rng.Uniform(-0.3, 0.3), rng.Uniform(-0.2, 0.2), 1.0);
  target.points.points3d.resize(grid * grid, 3);
  target.points.points2d.resize(grid * grid, 2);
  for (int i = 0; i < grid * grid; ++i) {
    const double step = 1.0 / (grid - 1);
    const Eigen::Vector3d x(i % grid * step - 0.5, i / grid * step - 0.5, relief * rng.Uniform(-0.5, 0.5));
    const Eigen::Vector2d image = (kCamera * (target.pose.rotation * x + target.pose.translation)).hnormalized();
    target.points.points3d.row(i) = x.transpose();
    target.points.points2d.row(i) << image[0] + noise_px * rng.Normal(), image[1] + noise_px * rng.Normal();
  }
  return target;
}

struct Tally {
  int flipped = 0, ambiguous = 0, silent = 0, wrong_other = 0;
};

Tally Study(int grid, double distance, double noise_px, double relief = 0.0) {
  Tally tally;
  for (int i = 0; i < 40; ++i) {
    const Target target = MakeTarget(i, grid, distance, noise_px, relief);
    const auto estimate = EstimateAbsolutePose(target.points, kCamera);
    REQUIRE(estimate.ok());
    const bool flipped = target.Flipped(estimate.pose->rotation);
    tally.flipped += flipped;
    tally.ambiguous += estimate.ambiguous_pose.has_value();
    tally.silent += flipped && !estimate.ambiguous_pose.has_value();
    tally.wrong_other +=
        estimate.ambiguous_pose.has_value() && target.Flipped(estimate.ambiguous_pose->rotation) == flipped;
    // A covariance of one pose would say nothing of the other.
    CHECK(estimate.pose_covariance.has_value() == !estimate.ambiguous_pose.has_value());
  }
  return tally;
}

TEST_CASE("planar targets far away: no pose is flipped without a word, and the other one is given") {
  for (const double noise_px : {0.3, 1.0}) {
    const Tally tally = Study(6, 50.0, noise_px);
    CAPTURE(noise_px, tally.flipped, tally.ambiguous, tally.silent, tally.wrong_other);
    CHECK(tally.flipped > 0);
    CHECK(tally.silent <= 1);
    CHECK(tally.wrong_other <= 1);
  }
}

TEST_CASE("planar targets near by: the pose is right and alone") {
  const Tally tally = Study(8, 3.0, 0.3);
  CHECK(tally.flipped == 0);
  CHECK(tally.ambiguous == 0);
}

TEST_CASE("a scene with relief far away has one pose") {
  const Tally tally = Study(8, 20.0, 0.3, 0.5);
  CHECK(tally.flipped == 0);
  CHECK(tally.ambiguous == 0);
}

}  // namespace
}  // namespace diffsac
