#include "diffsac/problem/tasks.h"
#include "lab/eval/metrics.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "diffsac/geometry/pose.h"
#include "geometry/two_view_problems.h"
#include "lab/eval/results.h"

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
      const EstimateError error = MeasureError(EstimateOf(-example.truth.model, 50), example);
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
    CHECK(MeasureError(estimate, example).rotation_deg == Approx(3.0).margin(1e-4));
    example.truth.pose->translation *= -1.0;  // The sign does not count.
    CHECK(MeasureError(estimate, example).translation_deg < 1e-4);
  }
}

TEST_CASE("Failures are the worst errors, and unknown truth is none") {
  Rng rng(3);
  Example example = MakePair(Task::kFundamental, rng);
  EstimateError error = MeasureError(Estimate(), example);
  CHECK(error.failed);
  CHECK(error.rotation_deg == 180.0);
  CHECK(error.translation_deg == 90.0);
  Estimate few = EstimateOf(example.truth.model, 50);
  few.inliers.assign(50, 0);
  CHECK(MeasureError(few, example).failed);
  example.truth.pose.reset();
  CHECK(std::isnan(MeasureError(EstimateOf(example.truth.model, 50), example).angle_deg));
}

TEST_CASE("Without a pose the error is the mean distance of the true inliers") {
  Rng rng(5);
  for (const Task task : {Task::kFundamental, Task::kEssential}) {
    Example example = MakePair(task, rng);
    example.truth.pose.reset();
    const Estimate estimate = EstimateOf(example.truth.model, 50);
    example.truth.inliers.assign(50, 1);
    CHECK(MeasureError(estimate, example).error_px < 1e-6);
    CHECK(std::isinf(MeasureError(Estimate(), example).error_px));
    // Two of five true inliers moved off their epipolar lines; the outliers' distances do not count.
    for (int i = 0; i < 50; ++i) example.problem.points(i, 3) += i < 2 || i >= 5 ? 4.0 : 0.0;
    std::fill(example.truth.inliers.begin() + 5, example.truth.inliers.end(), 0);
    const double error = MeasureError(estimate, example).error_px;
    CHECK(error > 0.01);
    CHECK(error <= 4.0 * 2 / 5);
    example.truth.inliers.assign(50, 0);
    CHECK(std::isnan(MeasureError(estimate, example).error_px));
  }
}

TEST_CASE("A homography's error is the mean transfer distance") {
  Rng rng(4);
  Example example;
  example.problem.task = Task::kHomography;
  const Matrix3Parameters h = testing::RandomHomography(rng);
  example.problem.points = testing::HomographyPoints(h, 30, rng);
  example.truth.model = h;
  CHECK(MeasureError(EstimateOf(-h, 30), example).error_px < 1e-6);
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = 3.0;
  shift(1, 2) = 4.0;
  const ModelParameters moved = AsParameters(shift * AsMatrix(h));
  CHECK(MeasureError(EstimateOf(moved, 30), example).error_px == Approx(5.0));
  CHECK(std::isinf(MeasureError(Estimate(), example).error_px));
}

/// A 16 x 12 image seen again, moved; the matches span the whole of image 1.
Example ShiftedImages(double dx, double dy) {
  Example example;
  example.problem.task = Task::kHomography;
  example.problem.points.resize(4, 4);
  example.problem.points << 0, 0, dx, dy, 15, 0, 15 + dx, dy, 0, 11, dx, 11 + dy, 15, 11, 15 + dx, 11 + dy;
  example.problem.size1 = example.problem.size2 = {16, 12};
  Eigen::Matrix3d truth = Eigen::Matrix3d::Identity();
  truth(0, 2) = dx;
  truth(1, 2) = dy;
  example.truth.model = AsParameters(truth);
  return example;
}

TEST_CASE("The jointly visible pixels are those whose true transfer falls inside image 2") {
  // Columns 2 6 10 14 and rows 2 6 10; moved by 6 and -3 only columns below 10 and rows above 2 stay inside.
  const std::vector<Eigen::Vector2d> pixels = JointlyVisiblePixels(ShiftedImages(6.0, -3.0));
  REQUIRE(pixels.size() == 4);
  CHECK(pixels[0] == Eigen::Vector2d(2, 6));
  CHECK(pixels[1] == Eigen::Vector2d(6, 6));
  CHECK(pixels[2] == Eigen::Vector2d(2, 10));
  CHECK(pixels[3] == Eigen::Vector2d(6, 10));
  CHECK(JointlyVisiblePixels(ShiftedImages(0.0, 0.0)).size() == 12);
  CHECK(JointlyVisiblePixels(ShiftedImages(40.0, 0.0)).empty());
  Example unknown = ShiftedImages(0.0, 0.0);
  unknown.problem.size2 = {};
  CHECK(JointlyVisiblePixels(unknown).empty());
}

TEST_CASE("What lies behind the horizon of a homography is not visible") {
  // w = 1 - x / 8: pixels beyond x = 8 are behind the second camera, though x = 14 has the transfer (8.3, 8.1 and
  // more).
  Example example = ShiftedImages(0.0, 0.0);
  example.problem.points.col(0) << 0, 5, 0, 5;
  Eigen::Matrix3d truth;
  truth << -0.8, 0.0, 5.0, -0.8, 0.01, 5.0, -0.125, 0.0, 1.0;
  for (const double sign : {1.0, -1.0}) {
    example.truth.model = AsParameters(Eigen::Matrix3d(sign * truth));
    const std::vector<Eigen::Vector2d> pixels = JointlyVisiblePixels(example);
    CHECK(pixels.size() == 6);
    for (const Eigen::Vector2d& pixel : pixels) CHECK(pixel[0] < 8.0);
  }
}

TEST_CASE("A homography's error is the mean over the jointly visible pixels") {
  // The estimate stretches x by 1.5: off by x / 2, so 1 and 3 at the visible columns 2 and 6. Over all four columns the
  // mean would be 4, over the box of the matches 3.75.
  const Example example = ShiftedImages(6.0, -3.0);
  Eigen::Matrix3d stretched;
  stretched << 1.5, 0.0, 6.0, 0.0, 1.0, -3.0, 0.0, 0.0, 1.0;
  const Estimate estimate = EstimateOf(AsParameters(stretched), 4);
  CHECK(MeasureError(estimate, example).error_px == Approx(2.0));
  Example unknown = example;
  unknown.problem.size1 = {};
  CHECK(MeasureError(estimate, unknown).error_px == Approx(3.75));
  const Example apart = ShiftedImages(40.0, 0.0);
  stretched(0, 2) = 40.0;
  stretched(1, 2) = 0.0;
  CHECK(MeasureError(EstimateOf(AsParameters(stretched), 4), apart).error_px == Approx(3.75));
}

cv::Mat ImagePoints(const PointMatrix& points, int image) {
  cv::Mat out(static_cast<int>(points.rows()), 2, CV_64F);
  for (int i = 0; i < out.rows; ++i)
    for (int j = 0; j < 2; ++j) out.at<double>(i, j) = points(i, 2 * image + j);
  return out;
}

TEST_CASE("A homography of views with a known pose has the error of its motion as well") {
  Rng rng(21);
  for (int trial = 0; trial < 50; ++trial) {
    Example example = MakePair(Task::kEssential, rng);
    example.problem.task = Task::kHomography;
    const auto& [K1, K2] = *example.problem.cameras;
    const RelativePose& pose = *example.truth.pose;
    const Eigen::Vector3d normal = Eigen::Vector3d(rng.Uniform(-0.2, 0.2), rng.Uniform(-0.2, 0.2), 1.0).normalized();
    const Eigen::Matrix3d H = K2 * (pose.rotation + 0.2 * pose.translation * normal.transpose()) * K1.inverse();
    example.truth.model = AsParameters(H);
    Estimate estimate = EstimateOf(AsParameters(H), static_cast<int>(example.problem.points.rows()));
    const EstimateError right = MeasureError(estimate, example);
    CHECK(right.rotation_deg < 1e-4);
    CHECK(right.translation_deg < 1e-3);
    CHECK(right.angle_deg == std::max(right.rotation_deg, right.translation_deg));
    estimate.model = AsParameters(K2 * K1.inverse());
    CHECK(MeasureError(estimate, example).rotation_deg ==
          Approx(RotationAngleDegrees(pose.rotation, Eigen::Matrix3d::Identity())).margin(1e-3));
    estimate.status = Status::kNoModel;
    estimate.model.resize(0);
    CHECK(MeasureError(estimate, example).angle_deg == 180.0);
  }
}

TEST_CASE("OpenCV's recoverPose gives the same errors on clean data") {
  Rng rng(6);
  int trials = 0;
  for (const Task task : {Task::kFundamental, Task::kEssential}) {
    for (int trial = 0; trial < 50; ++trial, ++trials) {
      const Example example = MakePair(task, rng);
      const Eigen::Matrix3d& k1 = example.problem.cameras->K1;
      const Eigen::Matrix3d& k2 = example.problem.cameras->K2;
      // A pose that is wrong by a little, so that both errors are of some degrees.
      RelativePose wrong = *example.truth.pose;
      wrong.rotation = Eigen::AngleAxisd(rng.Uniform(0.005, 0.03), testing::RandomDirection(rng)) * wrong.rotation;
      wrong.translation = (wrong.translation + rng.Uniform(0.01, 0.1) * testing::RandomDirection(rng)).normalized();
      const Eigen::Matrix3d essential = EssentialFromPose(wrong);
      const ModelParameters model = task == Task::kEssential
                                        ? AsParameters(essential)
                                        : AsParameters(FundamentalFromEssential(essential, k1, k2));
      const PointMatrix points = NormalizedCoordinates(example.problem.points, k1, k2);
      cv::Mat e(3, 3, CV_64F), r, t, mask, space;
      for (int i = 0; i < 9; ++i) e.at<double>(i / 3, i % 3) = essential(i / 3, i % 3);
      cv::recoverPose(e, ImagePoints(points, 0), ImagePoints(points, 1), cv::Mat::eye(3, 3, CV_64F), r, t, 1e6, mask,
                      space);
      Eigen::Matrix3d rotation;
      for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = r.at<double>(i / 3, i % 3);
      const Eigen::Vector3d translation(t.at<double>(0), t.at<double>(1), t.at<double>(2));
      const double angle = DirectionAngleDegrees(translation, example.truth.pose->translation);
      const EstimateError error = MeasureError(EstimateOf(model, 50), example);
      CHECK(error.rotation_deg == Approx(RotationAngleDegrees(rotation, example.truth.pose->rotation)).margin(1e-6));
      CHECK(error.translation_deg == Approx(std::min(angle, 180.0 - angle)).margin(1e-6));
      CHECK(error.rotation_deg > 0.1);
    }
  }
  CHECK(trials == 100);
}

TEST_CASE("Accuracy in pixels counts ten thresholds evenly spaced in their logarithms") {
  const Tolerance pixels(20.0, true);
  CHECK(AverageAccuracyWithin(1.0, pixels) == 1.0);
  CHECK(AverageAccuracyWithin(20.0, pixels) == Approx(0.1));
  CHECK(AverageAccuracyWithin(20.1, pixels) == 0.0);
  CHECK(AverageAccuracyWithin(std::sqrt(20.0), pixels) == Approx(0.5));
  CHECK(MetricName("mAA", pixels) == "mAA@20px");
}

}  // namespace
}  // namespace diffsac
