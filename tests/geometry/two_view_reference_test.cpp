// OpenCV as an independent reference for everything it offers too, on clean data.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/homography_decomposition.h"
#include "diffsac/geometry/pose.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::FundamentalDistance;
using testing::HomographyDistance;
using testing::ModelDistance;
using testing::RandomProblem;

/// OpenCV's F and H take single-precision points; so that both see the same ones.
PointMatrix SinglePrecision(const PointMatrix& points) { return points.cast<float>().cast<double>(); }

cv::Mat ImagePoints(const PointMatrix& points, int image) {
  cv::Mat out(static_cast<int>(points.rows()), 2, CV_64F);
  for (int i = 0; i < out.rows; ++i)
    for (int j = 0; j < 2; ++j) out.at<double>(i, j) = points(i, 2 * image + j);
  return out;
}

Eigen::Matrix3d ToEigen(const cv::Mat& mat, int first_row = 0) {
  Eigen::Matrix3d out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out(i, j) = mat.at<double>(first_row + i, j);
  return out;
}

cv::Mat ToOpenCv(const Eigen::Matrix3d& matrix) {
  cv::Mat out(3, 3, CV_64F);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out.at<double>(i, j) = matrix(i, j);
  return out;
}

TEST_CASE("OpenCV's 7-point algorithm has the same solutions") {
  Rng rng(1);
  const int set[] = {0, 1, 2, 3, 4, 5, 6};
  int compared = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const PointMatrix points = SinglePrecision(RandomProblem(7, rng).pixels);
    const cv::Mat f = cv::findFundamentalMat(ImagePoints(points, 0), ImagePoints(points, 1), cv::FM_7POINT);
    Matrix3Parameters models[3];
    const int count = SolveSevenPoints(points, set, models);
    if (f.rows != 3 * count) continue;  // a near-double root may be counted either way
    for (int i = 0; i < count; ++i) {
      double best = 2.0;
      for (int j = 0; j < count; ++j)
        best = std::min(best, FundamentalDistance(models[i], AsParameters(ToEigen(f, 3 * j))));
      compared += best < 1e-5 ? 1 : 0;
      // OpenCV does not normalise the points of its 7-point algorithm: solutions far from the data differ more.
      CHECK(best < 1e-3);
    }
  }
  CHECK(compared > 600);
}

TEST_CASE("OpenCV's 8-point algorithm gives the same F on clean points") {
  Rng rng(2);
  for (int trial = 0; trial < 100; ++trial) {
    const PointMatrix points = SinglePrecision(RandomProblem(30, rng).pixels);
    const cv::Mat f = cv::findFundamentalMat(ImagePoints(points, 0), ImagePoints(points, 1), cv::FM_8POINT);
    REQUIRE(f.rows == 3);
    Matrix3Parameters model;
    REQUIRE(Fundamental::Fit(points, Eigen::VectorXd::Ones(30), &model));
    CHECK(FundamentalDistance(model, AsParameters(ToEigen(f))) < 1e-6);
  }
}

TEST_CASE("OpenCV's E, its decomposition and its pose agree on clean points") {
  Rng rng(3);
  const int set[] = {0, 1, 2, 3, 4};
  for (int trial = 0; trial < 100; ++trial) {
    const auto problem = RandomProblem(30, rng);
    const cv::Mat first = ImagePoints(problem.normalized, 0), second = ImagePoints(problem.normalized, 1);
    const cv::Mat e = cv::findEssentialMat(first, second, cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.9999, 1e-6);
    REQUIRE(e.rows == 3);
    Matrix3Parameters models[10];
    const int count = Essential::SolveMinimal(problem.normalized, set, models);
    double best = 2.0;
    for (int i = 0; i < count; ++i) best = std::min(best, ModelDistance(models[i], AsParameters(ToEigen(e))));
    CHECK(best < 1e-5);

    const cv::Mat truth = ToOpenCv(AsMatrix(problem.essential));
    cv::Mat r1, r2, t, r;
    cv::decomposeEssentialMat(truth, r1, r2, t);
    for (const RelativePose& pose : DecomposeEssential(AsMatrix(problem.essential)))
      CHECK(std::min(RotationAngleDegrees(pose.rotation, ToEigen(r1)),
                     RotationAngleDegrees(pose.rotation, ToEigen(r2))) < 1e-6);
    const int in_front = cv::recoverPose(truth, first, second, cv::Mat::eye(3, 3, CV_64F), r, t);
    const PoseChoice choice = ChoosePose(AsMatrix(problem.essential), problem.normalized);
    REQUIRE(choice.status == Status::kOk);
    CHECK(choice.in_front >= in_front);  // OpenCV leaves out points beyond 50 baselines
    CHECK(RotationAngleDegrees(choice.pose.rotation, ToEigen(r)) < 1e-6);
    CHECK((choice.pose.translation - Eigen::Vector3d(t.at<double>(0), t.at<double>(1), t.at<double>(2))).norm() < 1e-8);
  }
}

TEST_CASE("OpenCV's 5-point algorithm has the same solutions") {
  Rng rng(6);
  const int set[] = {0, 1, 2, 3, 4};
  int same_count = 0, compared = 0, agreed = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto problem = RandomProblem(5, rng);
    const cv::Mat e = cv::findEssentialMat(ImagePoints(problem.normalized, 0), ImagePoints(problem.normalized, 1),
                                           cv::Mat::eye(3, 3, CV_64F), cv::RANSAC, 0.999, 1e-6);
    Matrix3Parameters models[10];
    const int count = SolveFivePoints(problem.normalized, set, models);
    same_count += e.rows == 3 * count ? 1 : 0;
    for (int j = 0; j < e.rows / 3; ++j) {
      double best = 2.0;
      for (int i = 0; i < count; ++i) best = std::min(best, ModelDistance(models[i], AsParameters(ToEigen(e, 3 * j))));
      ++compared;
      agreed += best < 1e-6 ? 1 : 0;
    }
  }
  CAPTURE(same_count, compared, agreed);
  CHECK(compared > 1000);
  CHECK(same_count >= 290);  // a near-double root may be counted either way
  CHECK(agreed >= 0.99 * compared);
}

TEST_CASE("OpenCV's Sampson distance is the square of ours") {
  Rng rng(7);
  const auto problem = RandomProblem(200, rng, 2.0);
  const cv::Mat f = ToOpenCv(AsMatrix(problem.fundamental));
  for (int i = 0; i < 200; ++i) {
    const double* point = problem.pixels.data() + 4 * i;
    const double squared =
        cv::sampsonDistance(cv::Vec3d(point[0], point[1], 1.0), cv::Vec3d(point[2], point[3], 1.0), f);
    CHECK(Fundamental::Residual(problem.fundamental, point) == Approx(std::sqrt(squared)).epsilon(1e-9));
  }
}

TEST_CASE("OpenCV's homography agrees, from four points and from many") {
  Rng rng(4);
  const int set[] = {0, 1, 2, 3};
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3Parameters truth = testing::RandomHomography(rng);
    const PointMatrix points = SinglePrecision(testing::HomographyPoints(truth, 30, rng));
    const cv::Mat many = cv::findHomography(ImagePoints(points, 0), ImagePoints(points, 1), 0);
    Matrix3Parameters model;
    REQUIRE(Homography::Fit(points, Eigen::VectorXd::Ones(30), &model));
    CHECK(HomographyDistance(model, AsParameters(ToEigen(many))) < 1e-6);
    const PointMatrix four = points.topRows(4);
    const cv::Mat minimal = cv::findHomography(ImagePoints(four, 0), ImagePoints(four, 1), 0);
    if (Homography::SolveMinimal(four, set, &model) == 1 && minimal.rows == 3)
      CHECK(HomographyDistance(model, AsParameters(ToEigen(minimal))) < 1e-6);
  }
}

TEST_CASE("OpenCV's homography decomposition has the same motions") {
  Rng rng(5);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Matrix3d k = testing::RandomCamera(rng);
    const Eigen::Matrix3d rotation = testing::RandomPose(rng).rotation;
    const Eigen::Vector3d translation = rng.Uniform(0.1, 0.6) * testing::RandomDirection(rng);
    const Eigen::Vector3d normal = Eigen::Vector3d(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.5, 0.5), 1.0).normalized();
    const Eigen::Matrix3d h = k * (rotation + translation * normal.transpose()) * k.inverse();
    std::vector<cv::Mat> rotations, translations, normals;
    const int count = cv::decomposeHomographyMat(ToOpenCv(h), ToOpenCv(k), rotations, translations, normals);
    const PlaneMotions motions = DecomposeHomography(h, k, k);
    REQUIRE(motions.count == count);
    for (int i = 0; i < count; ++i) {
      double best = 1e9;
      for (int j = 0; j < count; ++j) {
        double difference = (motions.motions[i].rotation - ToEigen(rotations[j])).norm();
        for (int a = 0; a < 3; ++a)
          difference += std::abs(motions.motions[i].translation[a] - translations[j].at<double>(a)) +
                        std::abs(motions.motions[i].normal[a] - normals[j].at<double>(a));
        best = std::min(best, difference);
      }
      CHECK(best < 1e-5);
    }
  }
}

}  // namespace
}  // namespace diffsac
