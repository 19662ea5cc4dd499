#include "diffsac/geometry/vanishing_camera.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "geometry/room_segments.h"

namespace diffsac {
namespace {

using testing::RoomSegments;

constexpr double kDegree = std::numbers::pi / 180.0;
const Eigen::Vector2d kMiddle(319.5, 239.5);
const FocalPrior kPrior{0.9 * 640.0, 0.43};

RoomSegments Room(double turn_deg, double pitch_deg, double roll_deg) {
  return {turn_deg * kDegree, pitch_deg * kDegree, roll_deg * kDegree, 0, 0.0, 0, Rng(1)};
}

/// Its vanishing points with other signs and lengths.
std::vector<Eigen::Vector3d> PointsOf(const RoomSegments& room) {
  return {3.0 * room.Point(0), -0.2 * room.Point(1), room.Point(2).normalized()};
}

std::optional<VanishingFocal> FocalOf(const std::vector<Eigen::Vector3d>& points) {
  return FocalOfVanishingPoints(points, std::vector<double>(points.size(), 1.0), kMiddle, kPrior);
}

std::optional<Horizon> HorizonOfAlike(const std::vector<Eigen::Vector3d>& points, const Eigen::Matrix3d& K) {
  return HorizonOf(points, std::vector<double>(points.size(), 1.0), K);
}

}  // namespace

TEST_CASE("two orthogonal directions say the focal length, whatever the sign of their points") {
  const RoomSegments room = Room(35, 12, 5);
  for (const auto& [a, b] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    CHECK(*FocalOfOrthogonal(room.Point(a), -2.0 * room.Point(b), kMiddle) == Approx(520.0));
    const auto found = FocalOf({room.Point(b), -room.Point(a)});
    REQUIRE(found);
    CHECK(found->focal_px == Approx(520.0));
    CHECK(found->orthogonal == std::vector<int>{0, 1});
  }
}

TEST_CASE("the focal length is that of three orthogonal directions, others are passed over") {
  const RoomSegments room = Room(-40, 15, -3);
  std::vector<Eigen::Vector3d> points = PointsOf(room);
  // The ridge of a roof, and a street that is askew.
  points.insert(points.begin(), room.K * (room.rotation * Eigen::Vector3d(0.0, 0.5, 1.0)));
  points.push_back(room.K * (room.rotation * Eigen::Vector3d(1.0, 0.0, 0.4)));
  const auto found = FocalOf(points);
  REQUIRE(found);
  CHECK(found->focal_px == Approx(520.0).epsilon(0.01));
  CHECK(found->orthogonal == std::vector<int>{1, 2, 3});
  CHECK(found->log_sigma < kMostFocalLogSigma);
}

TEST_CASE("the standard deviation of the focal length is what angles that are off make of it") {
  const RoomSegments room = Room(40, 10, 0);
  Rng rng(7);
  double sum = 0.0, expected = 0.0;
  const int count = 400;
  for (int i = 0; i < count; ++i) {
    std::vector<Eigen::Vector3d> points;
    // Two of them: the angle between them is then off by kAngleSigmaDeg.
    for (const int axis : {0, 2}) {
      const double sigma = kAngleSigmaDeg * kDegree / std::sqrt(2.0);
      const Eigen::Vector3d off(rng.Normal(), rng.Normal(), rng.Normal());
      points.push_back(room.K * (room.rotation.col(axis) + sigma * off));
    }
    const auto found = FocalOf(points);
    REQUIRE(found);
    sum += std::pow(std::log(found->focal_px / 520.0), 2.0) / count;
    expected += found->log_sigma / count;
  }
  CHECK(std::sqrt(sum) == Approx(expected).epsilon(0.15));
}

TEST_CASE("where no two directions show the focal length there is none") {
  const RoomSegments frontal = Room(0, 0, 0), level = Room(35, 0, 0);
  CHECK_FALSE(FocalOf(PointsOf(frontal)));
  CHECK_FALSE(FocalOf({}));
  CHECK_FALSE(FocalOf({level.Point(0)}));
  CHECK_FALSE(FocalOf({level.Point(0), level.Point(1)}));  // The second is at infinity.
  CHECK_FALSE(FocalOf({Eigen::Vector3d(700, 240, 1), Eigen::Vector3d(900, 240, 1)}));
  // Nearly frontal: a little noise would make any focal length of it.
  CHECK_FALSE(FocalOf(PointsOf(Room(2, 1, 0))));
  // Level, with the vertical direction at infinity: the two others do.
  CHECK(FocalOf(PointsOf(level))->focal_px == Approx(520.0));
}

TEST_CASE("the horizon of a pitched and rolled camera, with and without the vertical direction") {
  for (const auto& [pitch, roll] : {std::pair{0.0, 0.0}, {12.0, -6.0}, {-20.0, 10.0}, {30.0, 3.0}}) {
    CAPTURE(pitch, roll);
    const RoomSegments room = Room(35, pitch, roll);
    const std::vector<Eigen::Vector3d> points = PointsOf(room);
    for (const bool vertical : {true, false}) {
      const auto horizon = vertical ? HorizonOfAlike(points, room.K) : HorizonOfAlike({points[0], points[2]}, room.K);
      REQUIRE(horizon);
      CHECK(horizon->vertical == (vertical ? 1 : -1));
      CHECK(horizon->horizontal == (vertical ? std::vector<int>{0, 2} : std::vector<int>{0, 1}));
      // The world's y axis points down.
      CHECK((horizon->up + room.rotation.col(1)).norm() < 1e-9);
      CHECK(horizon->line.head<2>().norm() == Approx(1.0));
      CHECK(horizon->line[1] > 0.0);
      for (const double angle : {0.1, 0.4, 2.8}) {
        const Eigen::Vector3d far = room.K * (room.rotation * Eigen::Vector3d(std::sin(angle), 0.0, std::cos(angle)));
        CHECK(std::abs(horizon->line.dot(far / far[2])) < 1e-6);
        CHECK(horizon->RowAt(far[0] / far[2]) == Approx(far[1] / far[2]).margin(1e-6));
      }
      CHECK(horizon->PitchDeg() == Approx(pitch).margin(1e-6));
      // Rolled clockwise by the rotation about the optical axis.
      CHECK(horizon->TiltDeg() == Approx(roll).margin(1e-6));
    }
  }
}

TEST_CASE("the vertical direction alone says the horizon, another one alone does not") {
  const RoomSegments room = Room(35, 10, 4);
  const auto horizon = HorizonOfAlike({room.Point(1)}, room.K);
  REQUIRE(horizon);
  CHECK(horizon->horizontal.empty());
  CHECK(horizon->PitchDeg() == Approx(10.0));
  CHECK_FALSE(HorizonOfAlike({room.Point(0)}, room.K));
  CHECK_FALSE(HorizonOfAlike({}, room.K));
  // Two that are nearly one.
  CHECK_FALSE(HorizonOfAlike({room.Point(0), room.Point(0) + Eigen::Vector3d(1.0, 1.0, 0.0)}, room.K));
}

TEST_CASE("directions look ahead, those across it up") {
  const Eigen::Matrix3d K = Room(0, 0, 0).K;
  CHECK((DirectionOf(-3.0 * (K * Eigen::Vector3d(0.1, 0.2, 1.0)), K) - Eigen::Vector3d(0.1, 0.2, 1.0).normalized())
            .norm() < 1e-12);
  CHECK((DirectionOf(K * Eigen::Vector3d(0.0, 1.0, 0.0), K) - Eigen::Vector3d(0.0, -1.0, 0.0)).norm() < 1e-12);
}

}  // namespace diffsac
