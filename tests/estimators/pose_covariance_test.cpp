// The covariance of what whole estimators find among outliers.

#include "diffsac/estimators/pose_covariance.h"

#include <catch2/catch.hpp>

#include "consensus/absolute_pose_scene.h"
#include "diffsac/estimators/classical.h"
#include "diffsac/estimators/presets.h"
#include "diffsac/problem/tasks.h"
#include "geometry/normalized_errors.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::kChiSquare95;
using testing::NormalizedError;
using testing::NormalizedErrors;
using testing::PoseError;

constexpr double kNoisePx = 0.5;

/// 300 matches of one camera, every third of them wrong.
Problem Views(int index, RelativePose* pose) {
  Rng rng = Rng(11).Fork("views", index);
  const testing::TwoViewProblem views = testing::RandomProblem(300, rng);
  const Eigen::Matrix3d K{{900.0, 0.0, 500.0}, {0.0, 900.0, 400.0}, {0.0, 0.0, 1.0}};
  Problem problem;
  problem.task = Task::kEssential;
  problem.inlier_threshold = 1.0;
  problem.cameras = CameraPair{K, K};
  problem.points = (900.0 * views.normalized).rowwise() + Eigen::RowVector4d(500.0, 400.0, 500.0, 400.0);
  for (Eigen::Index i = 0; i < problem.points.rows(); ++i) {
    for (int j = 0; j < 4; ++j) problem.points(i, j) += kNoisePx * rng.Normal();
    if (i % 3 == 0) problem.points.row(i).tail<2>() << rng.Uniform(0.0, 1000.0), rng.Uniform(0.0, 800.0);
  }
  *pose = views.pose;
  return problem;
}

NormalizedErrors ErrorsOf(const ClassicalOptions& options, int problems) {
  const ClassicalEstimator estimator(options);
  NormalizedErrors errors;
  for (int i = 0; i < problems; ++i) {
    RelativePose truth;
    const Problem problem = Views(i, &truth);
    const Estimate estimate = estimator.Run(problem, 1);
    REQUIRE(estimate.pose_covariance);
    REQUIRE(estimate.pose_covariance->rows() == 6);
    const auto pose = PoseOfEstimate(estimate.model, estimate.inliers, problem);
    REQUIRE(pose);
    const auto error = PoseError(truth, {pose->rotation, pose->translation});
    errors.values.push_back(NormalizedError(error, *estimate.pose_covariance, 5));
  }
  return errors;
}

TEST_CASE("errors of estimated essential matrices are what their covariances say", "[covariance]") {
  const auto check = [](const NormalizedErrors& errors) {
    CAPTURE(errors.Mean(), errors.ShareBeyond(kChiSquare95[5]));
    CHECK(errors.Mean() > 4.0);
    CHECK(errors.Mean() < 6.5);
    CHECK(errors.ShareBeyond(kChiSquare95[5]) < 0.12);
  };
  SECTION("over scales, ten refined") { check(ErrorsOf(RecommendedClassical(Task::kEssential), 150)); }
  SECTION("at one threshold") { check(ErrorsOf(LoRansacOptions(Task::kEssential), 150)); }
}

TEST_CASE("errors of estimated absolute poses are what their covariances say", "[covariance]") {
  const ClassicalEstimator estimator(RecommendedClassical(Task::kAbsolutePose));
  NormalizedErrors errors;
  for (int i = 0; i < 300; ++i) {
    const auto scene = testing::MakeAbsolutePoseScene(120, 0.4, 1.0 / 900.0, Rng(5).Fork("pose", i));
    Problem problem;
    problem.task = Task::kAbsolutePose;
    problem.inlier_threshold = 4.0;
    problem.points = scene.points;
    problem.points.rightCols(2) *= 900.0;
    const Eigen::Matrix3d K = Eigen::Vector3d(900.0, 900.0, 1.0).asDiagonal();
    problem.cameras = CameraPair{K, K};
    const Estimate estimate = estimator.Run(problem, 1);
    REQUIRE(estimate.pose_covariance);
    const RelativePose truth{RotationOf(scene.truth), TranslationOf(scene.truth)};
    const auto error = PoseError(truth, {RotationOf(estimate.model), TranslationOf(estimate.model)});
    errors.values.push_back(NormalizedError(error, *estimate.pose_covariance, 6));
  }
  CAPTURE(errors.Mean(), errors.ShareBeyond(kChiSquare95[6]));
  CHECK(errors.Mean() > 5.0);
  CHECK(errors.Mean() < 7.5);
  CHECK(errors.ShareBeyond(kChiSquare95[6]) < 0.12);
}

TEST_CASE("what is not refined, has no pose or turns in place has no covariance", "[covariance]") {
  RelativePose pose;
  Problem problem = Views(0, &pose);
  ClassicalOptions plain = LoRansacOptions(Task::kEssential);
  plain.consensus.final_refinement = FinalRefinement::kNone;
  CHECK_FALSE(ClassicalEstimator(plain).Run(problem, 1).pose_covariance);
  const ClassicalEstimator refining(LoRansacOptions(Task::kEssential));
  CHECK(refining.Run(problem, 1).pose_covariance);
  Problem few = problem;
  few.points = problem.points.topRows(4);
  CHECK_FALSE(refining.Run(few, 1).pose_covariance);
  few.points = problem.points.row(1).replicate(50, 1);
  CHECK_FALSE(refining.Run(few, 1).pose_covariance);

  Problem turned = problem;
  const Eigen::Matrix3d& K = problem.cameras->K1;
  const Eigen::Matrix3d turn = K * pose.rotation * K.inverse();
  for (Eigen::Index i = 0; i < turned.points.rows(); ++i)
    turned.points.row(i).tail<2>() =
        (turn * turned.points.row(i).head<2>().transpose().homogeneous()).hnormalized().transpose();
  CHECK_FALSE(refining.Run(turned, 1).pose_covariance);

  problem.task = Task::kHomography;
  CHECK_FALSE(ClassicalEstimator(LoRansacOptions(Task::kHomography)).Run(problem, 1).pose_covariance);
}

}  // namespace
}  // namespace diffsac
