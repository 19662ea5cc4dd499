#include "lab/eval/problem_quantities.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/core/random.h"
#include "diffsac/problem/tasks.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

/// E of 50 exact matches, with a covariance of `sigma` radians in every direction.
Estimate Exact(double sigma, Example* example) {
  Rng rng(1);
  const testing::TwoViewProblem views = testing::RandomProblem(50, rng);
  example->problem.task = Task::kEssential;
  example->problem.points = views.normalized;
  example->problem.cameras = CameraPair{};
  example->truth.pose = views.pose;
  Estimate estimate;
  estimate.status = Status::kOk;
  estimate.model = views.essential;
  estimate.inliers.assign(50, 1);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(6, 6);
  covariance.bottomRightCorner<3, 3>() -= views.pose.translation * views.pose.translation.transpose();
  estimate.pose_covariance = sigma * sigma * covariance;
  return estimate;
}

}  // namespace

TEST_CASE("quantiles of chi-squared are those of tables") {
  const double of_68[] = {0.989, 2.279, 3.506, 4.695, 5.861, 7.006},
               of_95[] = {3.841, 5.991, 7.815, 9.488, 11.07, 12.592};
  for (int freedom = 1; freedom <= 6; ++freedom) {
    CHECK(ChiSquareBelow(of_68[freedom - 1], freedom) == Approx(0.68).margin(1e-3));
    CHECK(ChiSquareBelow(of_95[freedom - 1], freedom) == Approx(0.95).margin(1e-3));
    CHECK(ChiSquareBelow(0.0, freedom) == 0.0);
    CHECK(ChiSquareBelow(1e4, freedom) == 1.0);
  }
}

TEST_CASE("a true pose that is so many standard deviations away has the level of its region") {
  Example example;
  const double sigma = 0.01;
  const Estimate estimate = Exact(sigma, &example);
  PoseLevels levels = PoseLevelsOf(estimate, example);
  CHECK(levels.rotation < 1e-6);
  CHECK(levels.translation < 1e-6);

  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  example.truth.pose->rotation = Eigen::AngleAxisd(sigma * std::sqrt(3.506), axis) * example.truth.pose->rotation;
  Eigen::Vector3d& t = example.truth.pose->translation;
  t = Eigen::AngleAxisd(sigma * std::sqrt(5.991), t.unitOrthogonal()) * t;
  levels = PoseLevelsOf(estimate, example);
  CHECK(levels.rotation == Approx(0.68).margin(1e-3));
  CHECK(levels.translation == Approx(0.95).margin(1e-3));
  t = -t;
  CHECK(PoseLevelsOf(estimate, example).translation == Approx(1.0));
  t.setZero();
  CHECK(std::isnan(PoseLevelsOf(estimate, example).translation));
}

TEST_CASE("without a covariance, a true pose or a pose there are no levels") {
  Example example;
  Estimate estimate = Exact(0.01, &example);
  Estimate none = estimate;
  none.pose_covariance.reset();
  CHECK(std::isnan(PoseLevelsOf(none, example).rotation));
  none = estimate;
  none.inliers.assign(50, 0);
  CHECK(std::isnan(PoseLevelsOf(none, example).rotation));
  example.truth.pose.reset();
  CHECK(std::isnan(PoseLevelsOf(estimate, example).rotation));
}

}  // namespace diffsac
