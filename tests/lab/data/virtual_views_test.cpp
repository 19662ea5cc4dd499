#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "lab/data/synthetic_matches.h"
#include "lab/data/virtual_views.h"

namespace diffsac {

TEST_CASE("random cameras keep to their ranges, and use them") {
  VirtualCameraOptions options;
  Eigen::Array2d least = {1.0, 1.0}, most = {-1.0, -1.0};
  for (int k = 0; k < 400; ++k) {
    const VirtualCamera camera = RandomCamera(options, Rng(5).Fork("camera", k));
    const double width = camera.size.width, height = camera.size.height, longer = std::max(width, height);
    CHECK((width >= 599.0 && width <= 2001.0));
    CHECK((height / width > 0.498 && height / width < 1.402));
    CHECK((camera.K(0, 0) >= 0.6 * longer && camera.K(0, 0) <= 1.8 * longer));
    CHECK(camera.K(1, 1) == camera.K(0, 0));
    const Eigen::Array2d offset = {camera.K(0, 2) / width - 0.5, camera.K(1, 2) / height - 0.5};
    CHECK(offset.abs().maxCoeff() <= options.principal_offset + 1e-12);
    least = least.min(offset);
    most = most.max(offset);
  }
  CHECK(least.maxCoeff() < -0.9 * options.principal_offset);
  CHECK(most.minCoeff() > 0.9 * options.principal_offset);
}

TEST_CASE("a second camera is the first one as often as asked") {
  VirtualCameraOptions options;
  const VirtualCamera first = RandomCamera(options, Rng(1));
  int same = 0;
  for (int k = 0; k < 1000; ++k) same += RandomSecondCamera(options, first, Rng(2).Fork("camera", k)).K == first.K;
  CHECK(same == Approx(700).margin(60));
}

TEST_CASE("tilted directions lie at the angle, all around the axis, directions and turns are as asked") {
  Rng rng(6);
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), directions = sum;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  constexpr int kTimes = 4000;
  for (int k = 0; k < kTimes; ++k) {
    const Eigen::Vector3d tilted = Tilted(axis, 30.0, rng), direction = RandomDirection(rng);
    CHECK(tilted.norm() == Approx(1.0));
    CHECK(tilted.dot(axis) == Approx(std::sqrt(0.75)));
    sum += tilted - tilted.dot(axis) * axis;
    CHECK(direction.norm() == Approx(1.0));
    directions += direction;
    squares += direction * direction.transpose();
  }
  CHECK(sum.norm() / kTimes < 0.03);
  CHECK(directions.norm() / kTimes < 0.05);
  CHECK((squares / kTimes - Eigen::Matrix3d::Identity() / 3.0).cwiseAbs().maxCoeff() < 0.03);
  const Eigen::Matrix3d turn = RandomRotation(40.0, rng);
  CHECK((turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-12);
  CHECK(turn.trace() == Approx(1.0 + 2.0 * std::cos(40.0 * std::acos(-1.0) / 180.0)));
}

TEST_CASE("a plane faces both cameras where the second one is on the side of the first, and not too near") {
  const VirtualPlane plane{Eigen::Vector3d::UnitZ(), 5.0};
  Rng rng(1);
  const auto faces = [&](double x, double z) {
    return plane.FacesBoth(MotionTo({x, 0.0, z}, RandomRotation(30.0, rng), {}));
  };
  CHECK(faces(0.0, 0.0));
  CHECK(faces(3.0, -20.0));
  CHECK(faces(3.0, 4.7));
  CHECK_FALSE(faces(3.0, 4.8));
  CHECK_FALSE(faces(0.0, 6.0));
}

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
