#include "diffsac/geometry/vanishing_point.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "diffsac/geometry/vanishing_camera.h"
#include "geometry/segments.h"

namespace diffsac {
namespace {

using testing::SegmentsTowards;

double AngleDegrees(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180.0 / 3.14159265358979;
}

const Eigen::Vector3d kPoints[] = {Eigen::Vector3d(0.3, -0.2, 1.0).normalized(), Eigen::Vector3d(1.0, 0.0, 0.0),
                                   Eigen::Vector3d(0.05, 1.0, -0.01).normalized(),
                                   Eigen::Vector3d(5.0, 1.0, 1.0).normalized()};

}  // namespace

TEST_CASE("two segments meet in their vanishing point, at infinity too") {
  for (const Eigen::Vector3d& truth : kPoints) {
    const PointMatrix segments = SegmentsTowards(truth, 2, 0.0, Rng(3));
    const int set[] = {0, 1};
    Eigen::Vector3d model;
    REQUIRE(VanishingPoint::SolveMinimal(segments, set, &model) == 1);
    CHECK(model.norm() == Approx(1.0));
    CHECK(AngleDegrees(model, truth) < 1e-6);
    for (int i = 0; i < 2; ++i) CHECK(VanishingPoint::Residual(model, segments.data() + 4 * i) < 1e-9);
  }
}

TEST_CASE("the residual is the sine of the angle at the segment's middle") {
  const double segment[] = {0.0, 0.0, 2.0, 0.0};
  // Seen from (1, 0): up by 30 degrees; straight up; along the segment; at infinity, by 45 degrees.
  CHECK(VanishingPoint::Residual({1.0 + std::sqrt(3.0), 1.0, 1.0}, segment) == Approx(0.5));
  CHECK(VanishingPoint::Residual({1.0, 7.0, 1.0}, segment) == Approx(1.0));
  CHECK(VanishingPoint::Residual({9.0, 0.0, 1.0}, segment) == Approx(0.0).margin(1e-12));
  CHECK(VanishingPoint::Residual({1.0, -1.0, 0.0}, segment) == Approx(std::sqrt(0.5)));
  const Eigen::Vector3d v(0.3, 0.5, 0.9);
  CHECK(VanishingPoint::Residual(v, segment) == Approx(VanishingPoint::Residual(-2.0 * v, segment)));
}

TEST_CASE("a segment of length 0, and one about the vanishing point, fit nothing") {
  const double point[] = {0.4, 0.4, 0.4, 0.4}, about[] = {-1.0, 0.0, 1.0, 0.0};
  CHECK(VanishingPoint::Residual({0.0, 1.0, 0.0}, point) == 1.0);
  CHECK(VanishingPoint::Residual({0.0, 0.0, 1.0}, about) == 1.0);
}

TEST_CASE("residuals over columns are those of each segment") {
  const PointMatrix segments = testing::RandomSegments(37, Rng(1));
  const Eigen::MatrixXd columns = segments;
  const double* pointers[] = {columns.col(0).data(), columns.col(1).data(), columns.col(2).data(),
                              columns.col(3).data()};
  std::vector<double> residuals(30);
  VanishingPoint::Residuals(kPoints[0], pointers, 5, 35, residuals.data());
  for (int i = 0; i < 30; ++i)
    CHECK(residuals[i] == VanishingPoint::Residual(kPoints[0], segments.data() + 4 * (i + 5)));
}

TEST_CASE("no vanishing point of segments on one line, of no length or not finite") {
  PointMatrix segments(4, 4);
  segments << 0, 0, 1, 1, 2, 2, 3, 3, 0.5, 0.1, 0.5, 0.1, 0, std::numeric_limits<double>::quiet_NaN(), 1, 0;
  Eigen::Vector3d model(0, 0, 1);
  for (const int other : {1, 2, 3}) {
    const int set[] = {0, other};
    CHECK(VanishingPoint::SolveMinimal(segments, set, &model) == 0);
  }
  CHECK_FALSE(VanishingPoint::Determined(segments.topRows(2)));
  CHECK_FALSE(VanishingPoint::Determined(segments.topRows(3)));
  CHECK_FALSE(VanishingPoint::Determined(segments));
  CHECK_FALSE(VanishingPoint::Determined(segments.topRows(1)));
  CHECK_FALSE(VanishingPoint::Fit(segments.topRows(2), Eigen::Vector2d(1, 1), &model));
  PointMatrix parallel(2, 4);
  parallel << 0, 0, 1, 0, 0, 1, 1, 1;
  CHECK(VanishingPoint::Determined(parallel));
}

TEST_CASE("the fit is the least weighted sum of squared residuals") {
  Rng rng(8);
  for (const Eigen::Vector3d& truth : kPoints) {
    const PointMatrix segments = SegmentsTowards(truth, 60, 0.01, rng.Fork("segments"));
    Eigen::VectorXd weights(60);
    for (double& weight : weights) weight = rng.Uniform(0.1, 1.0);
    const auto cost = [&](const Eigen::Vector3d& v) {
      double sum = 0.0;
      for (int i = 0; i < 60; ++i)
        sum += weights[i] * std::pow(VanishingPoint::Residual(v, segments.data() + 4 * i), 2);
      return sum;
    };
    Eigen::Vector3d model;
    REQUIRE(VanishingPoint::Fit(segments, weights, &model));
    CHECK(AngleDegrees(model, truth) < 2.0);
    const double least = cost(model);
    for (int round = 0; round < 50; ++round) {
      Eigen::Vector3d moved = model + 1e-3 * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
      CHECK(cost(moved.normalized()) >= least * (1.0 - 1e-9));
    }
  }
}

TEST_CASE("a segment of weight 0 has no part in the fit") {
  const PointMatrix segments = SegmentsTowards(kPoints[0], 20, 0.01, Rng(2));
  PointMatrix more = testing::Stacked(segments, testing::RandomSegments(5, Rng(4)));
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(25);
  weights.tail(5).setZero();
  Eigen::Vector3d alone, among;
  REQUIRE(VanishingPoint::Fit(segments, Eigen::VectorXd::Ones(20), &alone));
  REQUIRE(VanishingPoint::Fit(more, weights, &among));
  CHECK(AngleDegrees(alone, among) < 1e-9);
}

TEST_CASE("the refinement finds the vanishing point among outliers, from some degrees off") {
  for (const Eigen::Vector3d& truth : kPoints) {
    const PointMatrix segments =
        testing::Stacked(SegmentsTowards(truth, 60, 0.002, Rng(5)), testing::RandomSegments(60, Rng(6)));
    Eigen::Vector3d model = (truth + 0.02 * Eigen::Vector3d(1.0, -1.0, 0.5)).normalized();
    REQUIRE(VanishingPoint::Refine(segments, Eigen::VectorXd::Ones(120), {LossKind::kTruncated, 0.05}, &model));
    CHECK(model.norm() == Approx(1.0));
    CHECK(AngleDegrees(model, truth) < 0.5);
  }
}

TEST_CASE("a refinement that can do nothing leaves the model") {
  const PointMatrix segments = SegmentsTowards(kPoints[0], 20, 0.0, Rng(2));
  Eigen::Vector3d model = kPoints[0];
  const Eigen::Vector3d before = model;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(20);
  for (const double threshold : {0.0, std::numeric_limits<double>::quiet_NaN()})
    CHECK_FALSE(VanishingPoint::Refine(segments, ones, {LossKind::kTruncated, threshold}, &model));
  CHECK_FALSE(VanishingPoint::Refine(segments, ones.head(3), RobustLoss{}, &model));
  model[0] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(VanishingPoint::Refine(segments, ones, RobustLoss{}, &model));
  model = before;
  CHECK_FALSE(VanishingPoint::Refine(PointMatrix(0, 4), Eigen::VectorXd(0), RobustLoss{}, &model));
  CHECK(model == before);
}

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
