#include "diffsac/eval/two_view_metrics.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/eval/results.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

Example MakePair(Task task, Rng& rng) {
  const testing::TwoViewProblem random = testing::RandomProblem(50, rng);
  Example example;
  example.problem.task = task;
  example.problem.points = random.pixels;
  example.problem.cameras = CameraPair{random.k1, random.k2};
  example.truth.pose = random.pose;
  example.truth.model = task == Task::kEssential ? random.essential : random.fundamental;
  return example;
}

Estimate EstimateOf(const ModelParameters& model, int points) {
  Estimate estimate;
  estimate.status = Status::kOk;
  estimate.model = model;
  estimate.inliers.assign(points, 1);
  return estimate;
}

TEST_CASE("The true F and E have no pose error, whatever their sign") {
  Rng rng(1);
  for (Task task : {Task::kFundamental, Task::kEssential})
    for (int trial = 0; trial < 20; ++trial) {
      const Example example = MakePair(task, rng);
      const EstimateError error = MeasureTwoViewError(EstimateOf(-example.truth.model, 50), example);
      CHECK(!error.failed);
      CHECK(error.rotation_deg < 1e-4);
      CHECK(error.translation_deg < 1e-4);
      CHECK(error.angle_deg == std::max(error.rotation_deg, error.translation_deg));
    }
}

TEST_CASE("A known rotation of the true pose is its error") {
  Rng rng(2);
  for (int trial = 0; trial < 20; ++trial) {
    Example example = MakePair(Task::kEssential, rng);
    const Estimate estimate = EstimateOf(example.truth.model, 50);
    const Eigen::AngleAxisd turn(3.0 * 3.14159265358979 / 180.0, Eigen::Vector3d::UnitY());
    example.truth.pose->rotation = turn * example.truth.pose->rotation;
    CHECK(MeasureTwoViewError(estimate, example).rotation_deg == Approx(3.0).margin(1e-4));
    example.truth.pose->translation *= -1.0;  // The sign does not count.
    CHECK(MeasureTwoViewError(estimate, example).translation_deg < 1e-4);
  }
}

TEST_CASE("Failures are the worst errors, and unknown truth is none") {
  Rng rng(3);
  Example example = MakePair(Task::kFundamental, rng);
  EstimateError error = MeasureTwoViewError(Estimate(), example);
  CHECK(error.failed);
  CHECK(error.rotation_deg == 180.0);
  CHECK(error.translation_deg == 90.0);
  Estimate few = EstimateOf(example.truth.model, 50);
  few.inliers.assign(50, 0);
  CHECK(MeasureTwoViewError(few, example).failed);
  example.truth.pose.reset();
  CHECK(std::isnan(MeasureTwoViewError(EstimateOf(example.truth.model, 50), example).angle_deg));
}

TEST_CASE("Without a pose the error is the mean distance of the true inliers") {
  Rng rng(5);
  for (const Task task : {Task::kFundamental, Task::kEssential}) {
    Example example = MakePair(task, rng);
    example.truth.pose.reset();
    const Estimate estimate = EstimateOf(example.truth.model, 50);
    example.truth.inliers.assign(50, 1);
    CHECK(MeasureTwoViewError(estimate, example).error_px < 1e-6);
    CHECK(std::isinf(MeasureTwoViewError(Estimate(), example).error_px));
    // Two of five true inliers moved off their epipolar lines; the outliers' distances do not count.
    for (int i = 0; i < 50; ++i) example.problem.points(i, 3) += i < 2 || i >= 5 ? 4.0 : 0.0;
    std::fill(example.truth.inliers.begin() + 5, example.truth.inliers.end(), 0);
    const double error = MeasureTwoViewError(estimate, example).error_px;
    CHECK(error > 0.01);
    CHECK(error <= 4.0 * 2 / 5);
    example.truth.inliers.assign(50, 0);
    CHECK(std::isnan(MeasureTwoViewError(estimate, example).error_px));
  }
}

TEST_CASE("A homography's error is the mean transfer distance") {
  Rng rng(4);
  Example example;
  example.problem.task = Task::kHomography;
  const Matrix3Parameters h = testing::RandomHomography(rng);
  example.problem.points = testing::HomographyPoints(h, 30, rng);
  example.truth.model = h;
  CHECK(MeasureTwoViewError(EstimateOf(-h, 30), example).error_px < 1e-6);
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = 3.0;
  shift(1, 2) = 4.0;
  const ModelParameters moved = AsParameters(shift * AsMatrix(h));
  CHECK(MeasureTwoViewError(EstimateOf(moved, 30), example).error_px == Approx(5.0));
  CHECK(std::isinf(MeasureTwoViewError(Estimate(), example).error_px));
}

TEST_CASE("Accuracy in pixels counts ten thresholds evenly spaced in their logarithms") {
  const Tolerance pixels(20.0, true);
  CHECK(AverageAccuracyWithin(1.0, pixels) == 1.0);
  CHECK(AverageAccuracyWithin(20.0, pixels) == Approx(0.1));
  CHECK(AverageAccuracyWithin(20.1, pixels) == 0.0);
  CHECK(AverageAccuracyWithin(std::sqrt(20.0), pixels) == Approx(0.5));
  CHECK(MetricName("mAA", pixels) == "mAA@20px");
}

// Field notes, section 4.2: seven errors and what the usual definitions make of them.
TEST_CASE("The metrics of poses agree with the worked example") {
  std::vector<ProblemRecord> records(7);
  const double errors[] = {0.5, 1.0, 3.2, 9.9, 10.0, 12.0, 180.0};
  std::vector<const ProblemRecord*> pointers;
  for (int i = 0; i < 7; ++i) {
    records[i].error.rotation_deg = errors[i];
    records[i].error.translation_deg = 0.0;
    records[i].error.angle_deg = errors[i];
    pointers.push_back(&records[i]);
  }
  const auto metrics = SceneMetrics("all", pointers, Tolerance(10.0), true);
  CHECK(FindMetric(metrics, "all", "mAA@10deg") == Approx(0.414286).margin(1e-6));
  CHECK(FindMetric(metrics, "all", "mAA_R@10deg") == Approx(0.414286).margin(1e-6));
  CHECK(FindMetric(metrics, "all", "mAA_t@10deg") == 1.0);
  CHECK(FindMetric(metrics, "all", "AUC@5deg") == Approx(0.34).margin(1e-6));
  CHECK(FindMetric(metrics, "all", "AUC@10deg") == Approx(0.433571).margin(1e-6));
  CHECK(FindMetric(metrics, "all", "AUC@20deg") == Approx(0.638571).margin(1e-6));
  CHECK(FindMetric(metrics, "all", "median_R_deg") == 9.9);
}

}  // namespace
}  // namespace diffsac
