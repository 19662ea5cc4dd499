#include "lab/data/local_similarity.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "lab/data/virtual_planes.h"

namespace diffsac {
namespace {

VirtualPair MakePair(const RigidMotion& motion) {
  VirtualPair pair;
  pair.first.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  pair.second.K << 800, 0, 400, 0, 800, 300, 0, 0, 1;
  pair.first.size = {640, 480};
  pair.second.size = {800, 600};
  pair.motion = motion;
  return pair;
}

RigidMotion MakeMotion(double roll, const Eigen::Vector3d& translation) {
  return {Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()).toRotationMatrix(), translation};
}

Eigen::Vector4d MatchOf(const VirtualPair& pair, const Eigen::Vector3d& point) {
  Eigen::Vector4d match;
  REQUIRE(ProjectIntoBoth(pair, point, 0.1, &match));
  return match;
}

}  // namespace

TEST_CASE("a camera that rolls and comes nearer turns and enlarges what is around a match") {
  const VirtualPair pair = MakePair(MakeMotion(0.4, {0.0, 0.0, -2.0}));
  for (const bool known : {false, true}) {
    const VirtualPlane plane{Eigen::Vector3d::UnitZ(), 5.0};
    std::vector<Eigen::Matrix3d> planes;
    if (known) planes.push_back(plane.Homography(pair));
    // Near the axis a patch that faces both cameras is on the plane.
    const Eigen::RowVector2d similarity = LocalSimilarity(pair, planes, MatchOf(pair, {0.01, -0.02, 5.0}));
    CHECK(similarity[0] == Approx(std::log((800.0 / 3.0) / (500.0 / 5.0))).margin(1e-3));
    CHECK(similarity[1] == Approx(0.4).margin(1e-3));
  }
  // At the epipole any depth is possible.
  CHECK(LocalSimilarity(pair, {}, MatchOf(pair, {0.0, 0.0, 5.0})).isApprox(Eigen::RowVector2d(std::log(1.6), 0.4)));
}

TEST_CASE("cameras with one centre have the similarity of their turn") {
  const VirtualPair pair = MakePair(MakeMotion(-2.5, Eigen::Vector3d::Zero()));
  const Eigen::RowVector2d similarity = LocalSimilarity(pair, {}, MatchOf(pair, {0.0, 0.0, 3.0}));
  CHECK(similarity[0] == Approx(std::log(800.0 / 500.0)));
  CHECK(similarity[1] == Approx(-2.5));
}

TEST_CASE("exchanged images have the inverse similarity, and a plane moves its neighbours by it") {
  RigidMotion motion = MakeMotion(0.3, {0.4, -0.2, 0.3});
  motion.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix() * motion.rotation;
  const VirtualPair pair = MakePair(motion);
  const VirtualPair exchanged{pair.second, pair.first, Inverse(motion)};
  const Eigen::Vector4d match = MatchOf(pair, {0.2, 0.1, 4.0});
  Eigen::Vector4d back;
  back << match.tail<2>(), match.head<2>();
  const Eigen::RowVector2d there = LocalSimilarity(pair, {}, match), again = LocalSimilarity(exchanged, {}, back);
  // A similarity is the nearest one to a map that is nearly one.
  CHECK((there + again).cwiseAbs().maxCoeff() < 0.01);

  const VirtualPlane plane{Eigen::Vector3d(0.5, -0.2, 1.0).normalized(), 3.0};
  const Eigen::Matrix3d H = plane.Homography(pair);
  Eigen::Vector4d on_plane;
  REQUIRE(plane.Match(pair, {1.0, 10.0}, {330.0, 250.0}, &on_plane));
  const Eigen::RowVector2d similarity = LocalSimilarity(pair, {Eigen::Matrix3d::Identity(), H}, on_plane);
  // Over all directions the similarity is the mean of what small steps do.
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  constexpr int kSteps = 360;
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::Rotation2Dd direction(2.0 * std::numbers::pi * i / kSteps);
    const Eigen::Vector2d step = 1e-3 * (direction * Eigen::Vector2d::UnitX());
    const Eigen::Vector2d moved = (H * (on_plane.head<2>() + step).homogeneous()).hnormalized() - on_plane.tail<2>();
    mean += direction.inverse() * moved / (1e-3 * kSteps);
  }
  CHECK(similarity[0] == Approx(std::log(mean.norm())).margin(1e-4));
  CHECK(similarity[1] == Approx(std::atan2(mean[1], mean[0])).margin(1e-4));
}

}  // namespace diffsac
