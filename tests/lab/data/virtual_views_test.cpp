#include "lab/data/virtual_views.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "lab/data/virtual_planes.h"

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

TEST_CASE("tilted directions lie at the angle, all around the axis; directions and turns are as asked") {
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

}  // namespace diffsac
