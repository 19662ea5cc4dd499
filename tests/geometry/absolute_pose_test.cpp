#include "diffsac/geometry/absolute_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

struct Scene {
  PointMatrix points;  ///< N × 5
  AbsolutePose::Parameters truth;
};

/// Points in a box of the given sides before a camera that looks about at it from 4 to 8 units away.
Scene MakeScene(int count, double noise, Rng& rng, const Eigen::Vector3d& sides = {2.0, 2.0, 2.0}) {
  const auto normal3 = [&] { return Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()); };
  const Eigen::Matrix3d rotation =
      Eigen::Quaterniond(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal()).normalized().toRotationMatrix();
  const Eigen::Vector3d middle = 10.0 * normal3();
  const Eigen::Vector3d seen(rng.Uniform(-1.0, 1.0), rng.Uniform(-1.0, 1.0), rng.Uniform(4.0, 8.0));
  const Eigen::Vector3d translation = seen - rotation * middle;
  Scene scene{PointMatrix(count, 5), PoseOf(rotation, translation)};
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d x;
    for (int j = 0; j < 3; ++j) x[j] = middle[j] + sides[j] * rng.Uniform(-1.0, 1.0);
    const Eigen::Vector3d camera = rotation * x + translation;
    scene.points.row(i) << x.transpose(), camera.head<2>().transpose() / camera[2];
    for (int j = 3; j < 5; ++j) scene.points(i, j) += noise * rng.Normal();
  }
  return scene;
}

double RotationErrorDegrees(const AbsolutePose::Parameters& a, const AbsolutePose::Parameters& b) {
  return Eigen::AngleAxisd(RotationOf(a).transpose() * RotationOf(b)).angle() * 180.0 / 3.14159265358979323846;
}

TEST_CASE("P3P: the true pose is among the solutions, each of which sees its points where they are") {
  Rng rng(1);
  int found = 0, most = 0;
  double worst = 0.0;
  constexpr int kTrials = 3000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Scene scene = MakeScene(3, 0.0, rng);
    const int set[3] = {0, 1, 2};
    AbsolutePose::Parameters poses[4];
    const int count = AbsolutePose::SolveMinimal(scene.points, set, poses);
    most = std::max(most, count);
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
      nearest = std::min(nearest, (poses[i] - scene.truth).norm() / scene.truth.norm());
      CHECK((RotationOf(poses[i]).transpose() * RotationOf(poses[i]) - Eigen::Matrix3d::Identity()).norm() < 1e-12);
      CHECK(RotationOf(poses[i]).determinant() > 0.0);
      for (int k = 0; k < 3; ++k)
        worst = std::max(worst, AbsolutePose::Residual(poses[i], scene.points.data() + 5 * k));
    }
    found += nearest < 1e-6 ? 1 : 0;
  }
  CAPTURE(found, worst);
  CHECK(found >= kTrials - 3);
  CHECK(worst < 1e-7);
  CHECK(most == 4);
}

TEST_CASE("P3P agrees with OpenCV's") {
  Rng rng(2);
  int agreed = 0, compared = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Scene scene = MakeScene(3, 0.0, rng);
    std::vector<cv::Point3d> object;
    std::vector<cv::Point2d> image;
    for (int i = 0; i < 3; ++i) {
      object.emplace_back(scene.points(i, 0), scene.points(i, 1), scene.points(i, 2));
      image.emplace_back(scene.points(i, 3), scene.points(i, 4));
    }
    std::vector<cv::Mat> rotations, translations;
    cv::solveP3P(object, image, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotations, translations, cv::SOLVEPNP_AP3P);
    const int set[3] = {0, 1, 2};
    AbsolutePose::Parameters poses[4];
    const int count = AbsolutePose::SolveMinimal(scene.points, set, poses);
    bool all = true;
    for (std::size_t k = 0; k < translations.size(); ++k) {
      const Eigen::Vector3d t(translations[k].at<double>(0), translations[k].at<double>(1),
                              translations[k].at<double>(2));
      const Eigen::Vector3d r(rotations[k].at<double>(0), rotations[k].at<double>(1), rotations[k].at<double>(2));
      const auto theirs = PoseOf(Eigen::AngleAxisd(r.norm(), r.normalized()).toRotationMatrix(), t);
      // It also returns poses with points behind the camera, and some that are not solutions.
      const auto sees = [&](int i) { return AbsolutePose::Residual(theirs, scene.points.data() + 5 * i) < 1e-6; };
      if (!sees(0) || !sees(1) || !sees(2)) continue;
      ++compared;
      all &= std::any_of(poses, poses + count,
                         [&](const auto& pose) { return (TranslationOf(pose) - t).norm() < 1e-4 * (1.0 + t.norm()); });
    }
    agreed += all ? 1 : 0;
  }
  CHECK(compared >= 200);
  CHECK(agreed >= 199);
}

TEST_CASE("Residuals of an absolute pose: pixels over the focal length, infinite behind the camera") {
  const auto pose = PoseOf(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.0, 0.0, 2.0));
  const double seen[5] = {1.0, 0.0, 0.0, 0.5, 0.0}, off[5] = {1.0, 0.0, 0.0, 0.8, 0.4};
  const double behind[5] = {1.0, 0.0, -3.0, 0.5, 0.0}, in_it[5] = {0.0, 0.0, -2.0, 0.0, 0.0};
  CHECK(AbsolutePose::Residual(pose, seen) == 0.0);
  CHECK(AbsolutePose::Residual(pose, off) == Approx(0.5));
  CHECK(std::isinf(AbsolutePose::Residual(pose, behind)));
  CHECK(std::isinf(AbsolutePose::Residual(pose, in_it)));
  Rng rng(3);
  const Scene scene = MakeScene(50, 0.01, rng);
  const Eigen::MatrixXd columns = scene.points;
  const double* pointers[5];
  for (int j = 0; j < 5; ++j) pointers[j] = columns.col(j).data();
  double residuals[50];
  AbsolutePose::Residuals(scene.truth, pointers, 3, 50, residuals);
  for (int i = 3; i < 50; ++i)
    CHECK(residuals[i - 3] == AbsolutePose::Residual(scene.truth, scene.points.data() + 5 * i));
}

TEST_CASE("Fits of absolute poses: exact data, planes and near planes, and the least squares of noisy data") {
  Rng rng(4);
  for (const double depth : {2.0, 0.1, 0.01, 1e-4, 0.0}) {
    for (int trial = 0; trial < 50; ++trial) {
      CAPTURE(depth, trial);
      const Scene exact = MakeScene(20, 0.0, rng, {2.0, 2.0, depth});
      AbsolutePose::Parameters pose;
      REQUIRE(AbsolutePose::Fit(exact.points, Eigen::VectorXd::Ones(20), &pose));
      CHECK((pose - exact.truth).norm() < 1e-5 * exact.truth.norm());
      const Scene noisy = MakeScene(40, 1e-3, rng, {2.0, 2.0, depth});
      REQUIRE(AbsolutePose::Fit(noisy.points, Eigen::VectorXd::Ones(40), &pose));
      CHECK(RotationErrorDegrees(pose, noisy.truth) < 2.0);
      const auto cost = [&](const AbsolutePose::Parameters& model) {
        double sum = 0.0;
        for (int i = 0; i < 40; ++i) sum += std::pow(AbsolutePose::Residual(model, noisy.points.data() + 5 * i), 2);
        return sum;
      };
      CHECK(cost(pose) <= cost(noisy.truth));
      // No small motion lowers it.
      for (int axis = 0; axis < 6; ++axis)
        for (const double sign : {-1.0, 1.0}) {
          const double step = sign * 1e-4;
          const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis % 3);
          const Eigen::Matrix3d turn =
              axis < 3 ? Eigen::AngleAxisd(step, unit).toRotationMatrix() : Eigen::Matrix3d::Identity();
          const Eigen::Vector3d shift = axis < 3 ? Eigen::Vector3d::Zero().eval() : Eigen::Vector3d(step * unit);
          CHECK(cost(PoseOf(turn * RotationOf(pose), TranslationOf(pose) + shift)) >= cost(pose) * (1.0 - 1e-9));
        }
    }
  }
}

TEST_CASE("Weights of zero leave points out of a fit, too few or collinear points have none") {
  Rng rng(5);
  Scene scene = MakeScene(30, 0.0, rng);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(30);
  for (int i = 0; i < 10; ++i) {
    scene.points(i, 3) += 0.5;
    weights[i] = 0.0;
  }
  AbsolutePose::Parameters pose = AbsolutePose::Parameters::Zero();
  REQUIRE(AbsolutePose::Fit(scene.points, weights, &pose));
  CHECK((pose - scene.truth).norm() < 1e-6 * scene.truth.norm());
  for (int i = 13; i < 30; ++i) weights[i] = 0.0;
  CHECK_FALSE(AbsolutePose::Fit(scene.points, weights, &pose));
  PointMatrix line = scene.points;
  for (int i = 0; i < 30; ++i) line.row(i).head<3>() = Eigen::RowVector3d(i, 2.0 * i, 5.0);
  CHECK_FALSE(AbsolutePose::Fit(line, Eigen::VectorXd::Ones(30), &pose));
  CHECK_FALSE(AbsolutePose::Determined(line));
  CHECK(AbsolutePose::Determined(scene.points));
  line = scene.points;
  for (int i = 0; i < 30; ++i) line.row(i).tail<2>() = Eigen::RowVector2d(0.01 * i, 0.02 * i);
  CHECK_FALSE(AbsolutePose::Determined(line));
  line(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(AbsolutePose::Determined(line));
  CHECK_FALSE(AbsolutePose::Determined(scene.points.topRows(2)));
}

TEST_CASE("Degenerate minimal sets have no absolute pose") {
  Rng rng(6);
  Scene scene = MakeScene(5, 0.0, rng);
  scene.points.row(1) = scene.points.row(0);
  scene.points.row(2).head<3>() = 2.0 * scene.points.row(3).head<3>() - scene.points.row(4).head<3>();
  AbsolutePose::Parameters poses[4];
  const int twins[3] = {0, 1, 3}, collinear[3] = {2, 3, 4};
  CHECK(AbsolutePose::SolveMinimal(scene.points, twins, poses) == 0);
  CHECK(AbsolutePose::SolveMinimal(scene.points, collinear, poses) == 0);
  scene.points(0, 2) = std::numeric_limits<double>::quiet_NaN();
  const int broken[3] = {0, 3, 4};
  CHECK(AbsolutePose::SolveMinimal(scene.points, broken, poses) == 0);
}

TEST_CASE("The refinement of an absolute pose ignores outliers and lowers the truncated cost") {
  Rng rng(7);
  int better = 0;
  for (int trial = 0; trial < 30; ++trial) {
    Scene scene = MakeScene(100, 1e-3, rng);
    for (int i = 0; i < 30; ++i)
      for (int j = 3; j < 5; ++j) scene.points(i, j) = rng.Uniform(-1.0, 1.0);
    const Eigen::Vector3d turn = 0.002 * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
    const Eigen::Matrix3d turned = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    AbsolutePose::Parameters pose = PoseOf(turned * RotationOf(scene.truth), turned * TranslationOf(scene.truth));
    const AbsolutePose::Parameters start = pose;
    REQUIRE(AbsolutePose::Refine(scene.points, 4e-3, &pose));
    better += RotationErrorDegrees(pose, scene.truth) < RotationErrorDegrees(start, scene.truth) ? 1 : 0;
    // At the minimum there is nothing to gain.
    AbsolutePose::Parameters again = pose;
    if (AbsolutePose::Refine(scene.points, 4e-3, &again)) CHECK((again - pose).norm() < 1e-5 * pose.norm());
  }
  CHECK(better >= 28);
  Scene scene = MakeScene(20, 0.0, rng);
  AbsolutePose::Parameters pose = scene.truth;
  CHECK_FALSE(AbsolutePose::Refine(scene.points, 0.0, &pose));
  CHECK_FALSE(AbsolutePose::Refine(scene.points, std::numeric_limits<double>::quiet_NaN(), &pose));
  CHECK(pose == scene.truth);
}

}  // namespace
}  // namespace diffsac
