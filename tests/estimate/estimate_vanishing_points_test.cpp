#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "diffsac/core/status.h"
#include "diffsac/diffsac.h"
#include "diffsac/problem/tasks.h"
#include "geometry/segments.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/eval/experiment.h"

namespace diffsac {
namespace {

using testing::RoomSegments;
using Segments = Eigen::Matrix<double, Eigen::Dynamic, 4>;

constexpr double kDegree = std::numbers::pi / 180.0;

RoomSegments Room() { return {40 * kDegree, 10 * kDegree, 3 * kDegree, 30, 0.2, 30, Rng(2)}; }

VanishingPointOptions Known(const RoomSegments& room) {
  VanishingPointOptions options;
  options.K = room.K;
  options.size = {640, 480};
  return options;
}

VanishingPointOptions Unknown() {
  VanishingPointOptions options;
  options.size = {640, 480};
  return options;
}

/// Degrees from each direction of the room to the nearest that was found.
double WorstAngle(const RoomSegments& room, const std::vector<Eigen::Vector3d>& found) {
  double worst = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    double least = 90.0;
    for (const Eigen::Vector3d& direction : found)
      least = std::min(least, std::acos(std::min(1.0, std::abs(direction.dot(room.rotation.col(axis))))) / kDegree);
    worst = std::max(worst, least);
  }
  return worst;
}

double ShareRight(const RoomSegments& room, const VanishingPointsEstimate& estimate) {
  int right = 0, all = 0;
  for (std::size_t i = 0; i < room.directions.size(); ++i) {
    if (room.directions[i] == 3) continue;
    ++all;
    if (estimate.assignment[i] == 0) continue;
    const Eigen::Vector3d& direction = estimate.directions[static_cast<std::size_t>(estimate.assignment[i] - 1)];
    right += std::abs(direction.dot(room.rotation.col(room.directions[i]))) > std::cos(2.0 * kDegree);
  }
  return double(right) / all;
}

/// A row of the shipped table.
std::unique_ptr<RobustEstimator> Row(const std::string& table, const std::string& name) {
  const std::string file = std::string(DIFFSAC_SOURCE_DIR) + "/configs/tables/" + table;
  const ExperimentOptions experiment = ReadExperiment(ConfigFromFile(file));
  for (const EstimatorRow& row : experiment.methods)
    if (row.name == name) return MakeEstimator(row.config, experiment.task, {});
  throw Error(table + ": no row " + name);
}

}  // namespace

TEST_CASE("vanishing points of a room: three directions, its segments, the horizon") {
  const RoomSegments room = Room();
  const VanishingPointsEstimate estimate = EstimateVanishingPoints(room.segments, Known(room));
  REQUIRE(estimate.ok());
  CHECK(estimate.points.size() == 3);
  REQUIRE(estimate.directions.size() == estimate.points.size());
  REQUIRE(estimate.values.size() == estimate.points.size());
  CHECK(WorstAngle(room, estimate.directions) < 1.0);
  CHECK(ShareRight(room, estimate) > 0.85);
  for (std::size_t k = 0; k < estimate.points.size(); ++k) {
    CHECK(estimate.points[k].norm() == Approx(1.0));
    CHECK(DirectionOf(estimate.points[k], room.K).dot(estimate.directions[k]) == Approx(1.0));
    CHECK(estimate.values[k] >= 0.35);
  }
  CHECK(estimate.K == room.K);
  CHECK_FALSE(estimate.focal);
  REQUIRE(estimate.horizon);
  CHECK(estimate.horizon->PitchDeg() == Approx(10.0).margin(0.7));
  CHECK(estimate.horizon->TiltDeg() == Approx(3.0).margin(0.7));
  const auto again = EstimateVanishingPoints(room.segments, Known(room));
  CHECK(again.points == estimate.points);
  CHECK(again.assignment == estimate.assignment);
}

TEST_CASE("without K the focal length is found from orthogonal vanishing points") {
  const RoomSegments room = Room();
  const VanishingPointsEstimate estimate = EstimateVanishingPoints(room.segments, Unknown());
  REQUIRE(estimate.ok());
  REQUIRE(estimate.focal);
  CHECK(estimate.focal->focal_px == Approx(520.0).epsilon(0.05));
  CHECK(estimate.focal->orthogonal.size() == 3);
  REQUIRE(estimate.K);
  CHECK((*estimate.K)(0, 0) == estimate.focal->focal_px);
  CHECK(WorstAngle(room, estimate.directions) < 2.5);
  REQUIRE(estimate.horizon);
  CHECK(estimate.horizon->TiltDeg() == Approx(3.0).margin(1.0));
}

TEST_CASE("a frontal view has a horizon and no focal length") {
  const RoomSegments room(0.0, 0.0, 0.0, 30, 0.2, 10, Rng(3));
  const VanishingPointsEstimate estimate = EstimateVanishingPoints(room.segments, Unknown());
  REQUIRE(estimate.ok());
  CHECK_FALSE(estimate.focal);
  CHECK_FALSE(estimate.K);
  CHECK(estimate.directions.empty());
  REQUIRE(estimate.horizon);
  CHECK(estimate.horizon->RowAt(320.0) == Approx(239.5).margin(5.0));
}

TEST_CASE("without a network vanishing points are those of most length") {
  const RoomSegments room = Room();
  VanishingPointOptions options = Known(room);
  options.guidance = Guidance::kNone;
  const VanishingPointsEstimate estimate = EstimateVanishingPoints(room.segments, options);
  REQUIRE(estimate.ok());
  CHECK(estimate.values.empty());
  CHECK(WorstAngle(room, estimate.directions) < 1.0);
}

TEST_CASE("segments that are no data for vanishing points give a status") {
  const RoomSegments room = Room();
  const Segments good = room.segments;
  for (const bool calibrated : {true, false})
    for (const bool network : {true, false}) {
      CAPTURE(calibrated, network);
      VanishingPointOptions options = calibrated ? Known(room) : Unknown();
      options.guidance = network ? Guidance::kNetwork : Guidance::kNone;
      const auto status = [&](const Segments& segments) { return EstimateVanishingPoints(segments, options).status; };
      CHECK(status(Segments(0, 4)) == Status::kTooFewPoints);
      CHECK(status(good.topRows(1)) == Status::kTooFewPoints);
      CHECK(status(Segments::Constant(9, 4, std::numeric_limits<double>::quiet_NaN())) == Status::kTooFewPoints);
      Segments points = good;
      points.rightCols(2) = points.leftCols(2);
      CHECK(status(points) == Status::kDegenerate);
      // One after the other on one line.
      Segments line(20, 4);
      for (int i = 0; i < 20; ++i) line.row(i) << 30 * i, 20 * i, 30 * i + 15, 20 * i + 10;
      CHECK(status(line) == Status::kDegenerate);
    }
}

TEST_CASE("a segment of length 0 is of no vanishing point and does no harm") {
  const RoomSegments room = Room();
  Segments segments = room.segments;
  segments.row(4).tail<2>() = segments.row(4).head<2>();
  const auto estimate = EstimateVanishingPoints(segments, Known(room));
  REQUIRE(estimate.ok());
  CHECK(estimate.assignment[4] == 0);
  CHECK(WorstAngle(room, estimate.directions) < 1.0);
}

TEST_CASE("parallel segments have one vanishing point, at infinity, and say no focal length") {
  Segments parallel(40, 4);
  for (int i = 0; i < 40; ++i) parallel.row(i) << 20 + 7 * i, 60, 20 + 7 * i, 300 + 2 * i;
  const auto estimate = EstimateVanishingPoints(parallel, Unknown());
  if (!estimate.ok()) {
    CHECK(estimate.status == Status::kNoModel);
    return;
  }
  CHECK(std::abs(estimate.points[0][1]) == Approx(1.0).margin(1e-6));
  CHECK_FALSE(estimate.focal);
}

TEST_CASE("options and missing sizes are refused by name") {
  const RoomSegments room = Room();
  const auto refused = [&](const VanishingPointOptions& options, const std::string& text) {
    CHECK_THROWS_WITH(EstimateVanishingPoints(room.segments, options), Catch::StartsWith(text));
  };
  refused({}, "size: expected the image's size, or K");
  VanishingPointOptions options = Known(room);
  options.K = Eigen::Matrix3d::Zero();
  refused(options, "K: expected a calibration matrix");
  options = Known(room);
  options.max_residual_deg = 0.0;
  refused(options, "max_residual_deg: expected");
  options = Known(room);
  options.least_value = 1.5;
  refused(options, "least_value: expected");
  options = Known(room);
  options.models_folder = "/none";
  refused(options, "/none/vanishing_point_chooser/model.safetensors: no such checkpoint");
  options.K.reset();
  refused(options, "/none/vanishing_point_chooser_uncalibrated/model.safetensors");
}

TEST_CASE("the function gives the digits of the tables' row, with K and without") {
  const RoomSegments room = Room();
  for (const bool calibrated : {true, false}) {
    CAPTURE(calibrated);
    Problem problem;
    problem.task = Task::kVanishingPoint;
    problem.points = room.segments;
    problem.inlier_threshold = 2.0;
    problem.size1 = {640, 480};
    if (calibrated) problem.cameras = CameraPair{room.K, room.K};
    VanishingPointOptions options = calibrated ? Known(room) : Unknown();
    options.seed = 5;
    const std::string table = calibrated ? "vanishing_points.yaml" : "vanishing_points_uncalibrated.yaml";
    const Estimate row = Row(table, "recommended")->Run(problem, 5);
    const auto estimate = EstimateVanishingPoints(room.segments, options);
    REQUIRE(row.instances.size() == estimate.points.size());
    for (std::size_t k = 0; k < row.instances.size(); ++k)
      CHECK(VanishingPointTask::PixelPoint(row.instances[k], problem) == estimate.points[k]);
    CHECK(row.instance_values == estimate.values);
    CHECK(row.assignment == estimate.assignment);
  }
}

}  // namespace diffsac
