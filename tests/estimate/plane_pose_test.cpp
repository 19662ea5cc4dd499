// The motion of calibrated cameras that see one plane: two explain the matches.

#include "diffsac/problem/plane_pose.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/core/random.h"
#include "diffsac/diffsac.h"
#include "diffsac/estimate/presets.h"
#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/tasks.h"
#include "estimate/make_estimator.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

const Eigen::Matrix3d kCamera{{1000.0, 0.0, 960.0}, {0.0, 1000.0, 540.0}, {0.0, 0.0, 1.0}};

struct Wall {
  Problem problem;
  RigidMotion motion;
  double ErrorOf(const RigidMotion& found) const {
    return std::max(RotationAngleDegrees(found.rotation, motion.rotation),
                    DirectionAngleDegrees(found.translation, motion.translation));
  }
};

/// 300 matches of a plane, of which `beside` lie before or behind it and one in twenty is wrong.
Wall MakeWall(Task task, int seed, double baseline = 0.3, double beside = 0.0, double noise = 0.3) {
  Rng rng = Rng(11).Fork("wall", seed);
  Wall wall;
  wall.motion.rotation = Eigen::AngleAxisd(0.2, testing::RandomDirection(rng)).toRotationMatrix();
  wall.motion.translation = baseline * testing::RandomDirection(rng);
  Problem& problem = wall.problem;
  problem.task = task;
  problem.inlier_threshold = DefaultThreshold(task);
  problem.size1 = problem.size2 = {1920, 1080};
  problem.cameras = CameraPair{kCamera, kCamera};
  problem.points.resize(300, 4);
  const Eigen::Vector3d normal(rng.Uniform(-0.3, 0.3), rng.Uniform(-0.3, 0.3), 1.0);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d pixel(rng.Uniform(0.0, 1920.0), rng.Uniform(0.0, 1080.0));
    const Eigen::Vector3d ray = kCamera.inverse() * pixel.homogeneous();
    const double depth = (i < 300 * beside ? rng.Uniform(0.6, 1.6) : 1.0) / normal.dot(ray);
    const Eigen::Vector3d second = wall.motion.rotation * ray * depth + wall.motion.translation;
    problem.points.row(i) << pixel.transpose(), (kCamera * second).hnormalized().transpose();
    if (i >= 285) problem.points.row(i).tail<2>() << rng.Uniform(0.0, 1920.0), rng.Uniform(0.0, 1080.0);
    for (int j = 0; j < 4; ++j) problem.points(i, j) += noise * rng.Normal();
  }
  return wall;
}

Estimate EstimateOf(const Wall& wall) {
  return MakeRow("prosac", wall.problem.task, "preset: recommended")->Run(wall.problem, 1);
}

PlaneViews ViewsOf(const Problem& problem, const std::vector<std::uint8_t>& inliers) {
  return {problem.points, inliers, *problem.cameras, problem.inlier_threshold};
}

/// Half of the poses of E were the other one, without a word.
TEST_CASE("a plane has two motions: one of them is right, of E, F and H") {
  for (const Task task : {Task::kEssential, Task::kFundamental, Task::kHomography}) {
    int two = 0, alone_and_wrong = 0;
    for (int seed = 0; seed < 15; ++seed) {
      const Wall wall = MakeWall(task, seed);
      const Estimate estimate = EstimateOf(wall);
      REQUIRE(estimate.status == Status::kOk);
      const auto& pose = estimate.pose;
      REQUIRE(pose);
      CHECK(pose->translation.norm() == Approx(1.0));
      two += estimate.ambiguous_pose.has_value();
      double least = wall.ErrorOf(*pose);
      if (estimate.ambiguous_pose) {
        least = std::min(least, wall.ErrorOf(*estimate.ambiguous_pose));
        CHECK_FALSE(estimate.pose_covariance);
      }
      alone_and_wrong += least > 2.0;
    }
    CAPTURE(ToString(task), two);
    CHECK(two >= 8);
    CHECK(alone_and_wrong <= 1);
  }
}

TEST_CASE("matches beside a plane say which of its motions is right") {
  for (const Task task : {Task::kEssential, Task::kHomography})
    for (int seed = 0; seed < 8; ++seed) {
      const Wall wall = MakeWall(task, seed, 0.3, 0.1);
      const Estimate estimate = EstimateOf(wall);
      const auto& pose = estimate.pose;
      CAPTURE(ToString(task), seed);
      REQUIRE(pose);
      CHECK_FALSE(estimate.ambiguous_pose);
      CHECK(wall.ErrorOf(*pose) < 1.0);
    }
}

TEST_CASE("a homography of a camera that turned has its rotation, and without cameras no pose") {
  for (const double noise : {0.0, 0.3, 1.0})
    for (int seed = 0; seed < 4; ++seed) {
      Wall wall = MakeWall(Task::kHomography, seed, 0.0, 0.0, noise);
      const Estimate estimate = EstimateOf(wall);
      CAPTURE(noise, seed);
      CHECK(estimate.degeneracy == Degeneracy::kPureRotation);
      const auto& pose = estimate.pose;
      REQUIRE(pose);
      CHECK(pose->translation.isZero(0.0));
      CHECK(RotationAngleDegrees(pose->rotation, wall.motion.rotation) < 0.2);
      wall.problem.cameras.reset();
      const Estimate without = EstimateOf(wall);
      CHECK(without.degeneracy == Degeneracy::kDetermined);
      CHECK_FALSE(without.pose);
      CHECK(without.model == estimate.model);
    }
}

TEST_CASE("poses of a plane do not depend on the homography's scale, the matches' order or the unit") {
  const Wall wall = MakeWall(Task::kHomography, 3);
  const Estimate estimate = EstimateOf(wall);
  const Eigen::Matrix3d h = ModelMatrix(estimate.model);
  const auto poses = PosesOfPlane(h, ViewsOf(wall.problem, estimate.inliers));
  REQUIRE(poses);
  Problem turned = wall.problem;
  turned.points = wall.problem.points.colwise().reverse();
  turned.points *= 1e-3;
  turned.inlier_threshold *= 1e-3;
  const Eigen::Matrix3d unit = Eigen::Vector3d(1e-3, 1e-3, 1.0).asDiagonal();
  turned.cameras = CameraPair{unit * kCamera, unit * kCamera};
  const std::vector<std::uint8_t> reversed(estimate.inliers.rbegin(), estimate.inliers.rend());
  const auto again = PosesOfPlane(-7.0 * (unit * h * unit.inverse()), ViewsOf(turned, reversed));
  REQUIRE(again);
  CHECK(again->pose.rotation.isApprox(poses->pose.rotation, 1e-9));
  CHECK(again->pose.translation.isApprox(poses->pose.translation, 1e-7));
  CHECK(again->other.has_value() == poses->other.has_value());
}

TEST_CASE("no poses of a plane come of bad input") {
  const Wall wall = MakeWall(Task::kHomography, 0);
  const std::vector<std::uint8_t> all(300, 1), none(300, 0);
  CHECK_FALSE(PosesOfPlane(Eigen::Matrix3d::Zero(), ViewsOf(wall.problem, all)));
  CHECK_FALSE(PosesOfPlane(Eigen::Matrix3d::Constant(std::nan("")), ViewsOf(wall.problem, all)));
  CHECK_FALSE(PosesOfPlane(ViewsOf(wall.problem, none)));
  Problem alike = wall.problem;
  alike.points.rowwise() = wall.problem.points.row(0);
  CHECK_FALSE(PosesOfPlane(ViewsOf(alike, all)));
  Problem line = wall.problem;
  line.points.col(1).setConstant(10.0);
  line.points.col(3).setConstant(10.0);
  CHECK_FALSE(PosesOfPlane(ViewsOf(line, all)));
}

}  // namespace
}  // namespace diffsac
