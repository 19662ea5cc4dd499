// The covariance of what whole estimators find among outliers.

#include "diffsac/estimate/pose_covariance.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/presets.h"
#include "diffsac/problem/tasks.h"
#include "geometry/normalized_errors.h"
#include "geometry/two_view_problems.h"
#include "ransac/absolute_pose_scene.h"

namespace diffsac {
namespace {

using testing::kChiSquare95;
using testing::NormalizedError;
using testing::NormalizedErrors;
using testing::PoseError;

constexpr double kNoisePx = 0.5;
constexpr double kChiSquareMedian5 = 4.351;

/// 300 matches of one camera, every `wrong`th of them wrong (0: none).
Problem Views(int index, int wrong, RelativePose* pose) {
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
    if (wrong > 0 && i % wrong == 0)
      problem.points.row(i).tail<2>() << rng.Uniform(0.0, 1000.0), rng.Uniform(0.0, 800.0);
  }
  *pose = views.pose;
  return problem;
}

NormalizedErrors ErrorsOf(const ClassicalOptions& options, int problems, int wrong) {
  const ClassicalEstimator estimator(options);
  NormalizedErrors errors;
  for (int i = 0; i < problems; ++i) {
    RelativePose truth;
    const Problem problem = Views(i, wrong, &truth);
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
  for (const ClassicalOptions& options : {RecommendedClassical(Task::kEssential), LoRansacOptions(Task::kEssential)}) {
    const NormalizedErrors errors = ErrorsOf(options, 200, 0);
    CAPTURE(errors.Mean(), errors.ShareBeyond(kChiSquare95[5]));
    CHECK(errors.Mean() > 4.3);
    CHECK(errors.Mean() < 5.8);
    CHECK(errors.ShareBeyond(kChiSquare95[5]) < 0.1);
  }
}

/// Those that chance has put on the epipolar lines have any depth, and no covariance knows that they are wrong.
TEST_CASE("among a third of wrong matches their median is", "[covariance]") {
  const NormalizedErrors errors = ErrorsOf(RecommendedClassical(Task::kEssential), 200, 3);
  CAPTURE(errors.ShareBeyond(kChiSquareMedian5), errors.ShareBeyond(kChiSquare95[5]));
  CHECK(errors.ShareBeyond(kChiSquareMedian5) > 0.4);
  CHECK(errors.ShareBeyond(kChiSquareMedian5) < 0.7);
  CHECK(errors.ShareBeyond(kChiSquare95[5]) < 0.2);
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

/// What f, the principal point and the lens leave open is more than noise says (docs/estimates.md).
TEST_CASE("a pose without a calibration has no covariance", "[covariance]") {
  RelativePose pose;
  Problem problem = Views(0, 0, &pose);
  problem.size1 = problem.size2 = {1001, 801};
  CHECK(ClassicalEstimator(RecommendedClassical(Task::kEssential)).Run(problem, 1).pose_covariance);
  problem.camera_prior1.K = problem.cameras->K1;
  problem.cameras.reset();
  for (const Task task : {Task::kSharedFocal, Task::kOneFocal, Task::kTwoFocals}) {
    problem.task = task;
    const Estimate estimate = ClassicalEstimator(RecommendedClassical(task)).Run(problem, 1);
    CHECK(estimate.focal);
    CHECK(PoseOfEstimate(estimate.model, estimate.inliers, problem));
    CHECK_FALSE(estimate.pose_covariance);
  }
}

TEST_CASE("what is not refined, has no pose or turns in place has no covariance", "[covariance]") {
  RelativePose pose;
  Problem problem = Views(0, 3, &pose);
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
