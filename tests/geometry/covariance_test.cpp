#include "diffsac/geometry/covariance.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/rotation.h"
#include "geometry/jacobian_check.h"
#include "geometry/normalized_errors.h"
#include "geometry/two_view_problems.h"
#include "ransac/absolute_pose_scene.h"

namespace diffsac {
namespace {

using testing::kChiSquare95;
using testing::MakeAbsolutePoseScene;
using testing::NormalizedError;
using testing::NormalizedErrors;
using testing::PoseError;
using testing::RandomProblem;
using testing::TwoViewProblem;

RelativePose Turned(const RelativePose& pose, const Eigen::VectorXd& step) {
  return {ExpRotation(step.head<3>()).toRotationMatrix() * pose.rotation, pose.translation + step.tail<3>()};
}

/// Of the four poses of E, that nearest to the truth.
RelativePose NearestPose(const Matrix3Parameters& essential, const RelativePose& truth) {
  RelativePose best;
  double least = std::numeric_limits<double>::infinity();
  for (const RelativePose& pose : DecomposeEssential(AsMatrix(essential))) {
    const double error = (pose.rotation - truth.rotation).norm() + (pose.translation - truth.translation).norm();
    if (error < least) best = pose;
    least = std::min(least, error);
  }
  return best;
}

/// How poses are fitted, lengths in σ of the noise.
struct Fitting {
  RobustLoss loss;
  double threshold = 0.0;
  bool weighted = false;  ///< By random weights.
  double outliers = 0.0;  ///< The share of points that are moved along the image.
};

/// Normalised errors of poses that are refined from the true ones.
NormalizedErrors PoseErrors(int problems, int points, const Fitting& fitting) {
  constexpr double kSigma = 5e-4;
  NormalizedErrors errors;
  for (int i = 0; i < problems; ++i) {
    Rng rng = Rng(7).Fork("covariance", i);
    const TwoViewProblem problem = RandomProblem(points, rng);
    PointMatrix matches = problem.normalized;
    for (int j = 0; j < points; ++j) {
      for (int k = 0; k < 4; ++k) matches(j, k) += kSigma * rng.Normal();
      if (j < static_cast<int>(fitting.outliers * points)) matches(j, 2) += rng.Uniform(-0.3, 0.3);
    }
    const RobustLoss& loss = fitting.loss;
    FitConditions fit{{loss.kind, loss.scale * kSigma, loss.least * kSigma}, fitting.threshold * kSigma};
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(points);
    if (fitting.weighted) {
      for (double& weight : weights) weight = rng.Uniform(0.05, 0.95);
      fit.weights = weights;
    }
    // Least squares first: from the truth itself, a loss with many minima stays too near to it.
    RefineOptions options;
    options.loss = {LossKind::kTrivial};
    Eigen::VectorXd right = weights;
    right.head(static_cast<Eigen::Index>(fitting.outliers * points)).setZero();
    Matrix3Parameters essential = problem.essential;
    RefineEssential(matches, right, options, &essential);
    options.loss = fit.loss;
    RefineEssential(matches, weights, options, &essential);
    const RelativePose pose = NearestPose(essential, problem.pose);
    const auto covariance = RelativePoseCovariance(matches, pose, fit);
    REQUIRE(covariance);
    errors.values.push_back(NormalizedError(PoseError(problem.pose, pose), *covariance, 5));
  }
  return errors;
}

/// χ² of `freedom` degrees: a little more since σ is estimated too, or less where a truncated loss, which has many
/// minima, keeps to that of its start.
void CheckChiSquare(const NormalizedErrors& errors, int freedom) {
  CAPTURE(errors.Mean(), errors.ShareBeyond(kChiSquare95[freedom]), freedom);
  CHECK(errors.Mean() > 0.93 * freedom);
  CHECK(errors.Mean() < 1.08 * freedom);
  CHECK(errors.ShareBeyond(kChiSquare95[freedom]) > 0.04);
  CHECK(errors.ShareBeyond(kChiSquare95[freedom]) < 0.07);
}

TEST_CASE("The derivative of E by a pose is that of finite differences", "[covariance]") {
  Rng rng(3);
  const RelativePose pose = testing::RandomPose(rng);
  const auto entries = [&](const Eigen::VectorXd& step) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> e = EssentialFromPose(Turned(pose, step));
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(e.data(), 9));
  };
  testing::CheckJacobian(entries, Eigen::VectorXd::Zero(6), EssentialByPose(pose));
}

TEST_CASE("The information of an absolute pose is that of finite differences", "[covariance]") {
  const auto scene = MakeAbsolutePoseScene(7, 0.0, 1e-3, Rng(2));
  const RelativePose pose{RotationOf(scene.truth), TranslationOf(scene.truth)};
  const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(7, 0.0, 1.2);
  const auto images = [&](const Eigen::VectorXd& step) {
    const RelativePose moved = Turned(pose, step);
    Eigen::VectorXd out(14);
    for (int i = 0; i < 7; ++i)
      out.segment<2>(2 * i) =
          std::sqrt(weights[i]) *
          (moved.rotation * scene.points.row(i).head<3>().transpose() + moved.translation).hnormalized();
    return out;
  };
  Eigen::MatrixXd jacobian(14, 6);
  for (int i = 0; i < 6; ++i) {
    const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(6, i);
    jacobian.col(i) = (images(step) - images(-step)) / 2e-6;
  }
  const Eigen::MatrixXd expected = jacobian.transpose() * jacobian;
  CHECK((ReprojectionInformation(scene.points, weights, scene.truth) - expected).norm() < 1e-8 * expected.norm());
}

TEST_CASE("Errors of 10 000 relative poses are chi-squared by their covariances", "[covariance]") {
  CheckChiSquare(PoseErrors(10000, 100, {{LossKind::kTrivial}, 100.0}), 5);
}

TEST_CASE("So they are whatever the loss, the threshold and the weights", "[covariance]") {
  const auto check = [](const Fitting& fitting) { CheckChiSquare(PoseErrors(4000, 300, fitting), 5); };
  SECTION("truncated at two sigma") { check({{LossKind::kTruncated, 2.0}, 2.0}); }
  SECTION("weighted") { check({{LossKind::kTrivial}, 100.0, true}); }
  SECTION("truncated, weighted") { check({{LossKind::kTruncated, 2.5}, 2.5, true}); }
  SECTION("over scales from sigma") { check({{LossKind::kMarginalised, 4.0, 1.0}, 2.5, true}); }
  SECTION("with outliers") { check({{LossKind::kTruncated, 3.0}, 3.0, false, 0.3}); }
}

TEST_CASE("Errors of absolute poses are chi-squared by their covariances", "[covariance]") {
  const double sigma = 1e-3;
  for (const double threshold : {2.5, 4.0}) {
    NormalizedErrors errors;
    for (int i = 0; i < 4000; ++i) {
      const auto scene = MakeAbsolutePoseScene(80, 0.2, sigma, Rng(5).Fork("pose", i));
      AbsolutePose::Parameters pose = scene.truth;
      AbsolutePose::Refine(scene.points, threshold * sigma, &pose);
      const FitConditions fit{{LossKind::kTruncated, threshold * sigma}, threshold * sigma, {}};
      const auto covariance = AbsolutePoseCovariance(scene.points, pose, fit);
      REQUIRE(covariance);
      const RelativePose truth{RotationOf(scene.truth), TranslationOf(scene.truth)};
      const auto error = PoseError(truth, {RotationOf(pose), TranslationOf(pose)});
      errors.values.push_back(NormalizedError(error, *covariance, 6));
    }
    CheckChiSquare(errors, 6);
  }
}

/// Five points determine a pose, six say how exact they are.
TEST_CASE("Without enough points, or with points that leave a direction open, there is no covariance", "[covariance]") {
  Rng rng(4);
  const TwoViewProblem problem = RandomProblem(40, rng, 0.5);
  const FitConditions fit{{LossKind::kTrivial}, 1.0};
  const auto of = [&](const PointMatrix& points) { return RelativePoseCovariance(points, problem.pose, fit); };
  for (const int count : {0, 1, 4, 5}) CHECK_FALSE(of(problem.normalized.topRows(count)));
  REQUIRE(of(problem.normalized.topRows(6)));
  CHECK(of(problem.normalized)->allFinite());
  CHECK_FALSE(of(problem.normalized.row(0).replicate(40, 1)));
  PointMatrix line = problem.normalized;
  for (int i = 0; i < 40; ++i) line.row(i) = line.row(0) + i * 1e-3 * Eigen::RowVector4d(1.0, 0.0, 1.0, 0.0);
  CHECK_FALSE(of(line));
  PointMatrix broken = problem.normalized;
  broken.row(3).setConstant(std::numeric_limits<double>::quiet_NaN());
  CHECK_FALSE(of(broken));
  CHECK_FALSE(of(PointMatrix::Zero(40, 4)));
}

TEST_CASE("A threshold or a loss that makes no sense, or noise beyond the threshold, gives no covariance",
          "[covariance]") {
  Rng rng(4);
  const TwoViewProblem problem = RandomProblem(400, rng, 0.5);
  const auto of = [&](const FitConditions& fit) {
    return RelativePoseCovariance(problem.normalized, problem.pose, fit);
  };
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  CHECK(of({{LossKind::kTrivial}, 0.01}));
  for (const double threshold : {0.0, -1.0, kInfinity, std::numeric_limits<double>::quiet_NaN(), 1e-5})
    CHECK_FALSE(of({{LossKind::kTrivial}, threshold}));
  CHECK_FALSE(of({{LossKind::kTruncated, 0.0}, 0.01}));
  CHECK_FALSE(of({{LossKind::kTrivial}, 0.01, Eigen::VectorXd::Zero(400)}));
  RelativePose none = problem.pose;
  none.translation.setZero();
  CHECK_FALSE(RelativePoseCovariance(problem.normalized, none, {{LossKind::kTrivial}, 0.01}));
  const auto scene = MakeAbsolutePoseScene(40, 0.0, 1e-3, Rng(2));
  for (const int count : {0, 1, 3})
    CHECK_FALSE(AbsolutePoseCovariance(scene.points.topRows(count), scene.truth, {{LossKind::kTrivial}, 0.1}));
  CHECK(AbsolutePoseCovariance(scene.points.topRows(4), scene.truth, {{LossKind::kTrivial}, 0.1}));
}

}  // namespace
}  // namespace diffsac
