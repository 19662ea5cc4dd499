#include "lab/ground_truth/pair_truth.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/geometry/rotation.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/two_view_test_util.h"

namespace diffsac {

TEST_CASE("the relative motion takes points from camera 1 to camera 2") {
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const RigidMotion camera1 = RandomCamera(&rng), camera2 = RandomCamera(&rng);
    const Eigen::Vector3d world = RandomVector(&rng);
    const auto apply = [](const RigidMotion& m, const Eigen::Vector3d& x) -> Eigen::Vector3d {
      return m.rotation * x + m.translation;
    };
    const RigidMotion relative = RelativeMotion(camera1, camera2);
    CHECK((apply(relative, apply(camera1, world)) - apply(camera2, world)).norm() < 1e-12);
    CHECK((apply(Inverse(camera1), apply(camera1, world)) - world).norm() < 1e-12);
  }
}

TEST_CASE("true matches are on the true epipolar geometry, outliers are not") {
  const CorrespondenceSet set = SyntheticSet(20, 60, Rng(2));
  for (const Example& pair : set.pairs) {
    const Eigen::VectorXd distances = TruthDistances(pair.problem, pair.truth);
    REQUIRE(distances.size() == 60);
    int near_outliers = 0;
    for (int k = 0; k < 60; ++k) {
      if (pair.truth.assignment[k] == 1) CHECK(distances[k] < 1e-9);
      if (pair.truth.assignment[k] == 0) near_outliers += distances[k] < 1.0 ? 1 : 0;
    }
    CHECK(near_outliers <= 10);
  }
}

TEST_CASE("the Sampson distance is the distance to first order, in pixels") {
  // Parallel cameras: the epipolar lines are rows, and a shift by d across them is shared by both images, d / sqrt 2.
  Problem problem;
  problem.points.resize(2, 4);
  problem.points << 10, 20, 40, 20, 10, 20, 40, 23;
  GroundTruth truth;
  truth.fundamental = CrossMatrix(Eigen::Vector3d(1, 0, 0));
  const Eigen::VectorXd distances = TruthDistances(problem, truth);
  CHECK(distances[0] == Approx(0.0).margin(1e-12));
  CHECK(distances[1] == Approx(3.0 / std::sqrt(2.0)));
  CHECK(distances.isApprox([&] {
    GroundTruth scaled;
    scaled.fundamental = -1e-7 * *truth.fundamental;
    return TruthDistances(problem, scaled);
  }()));
}

TEST_CASE("a homography's distance is the transfer error in image 2") {
  Problem problem;
  problem.points.resize(3, 4);
  problem.points << 1, 2, 7, 10, 1, 2, 7, 14, std::nan(""), 2, 7, 10;
  GroundTruth truth;
  truth.homography = (Eigen::Matrix3d() << 2, 0, 5, 0, 2, 6, 0, 0, 1).finished();
  truth.fundamental = Eigen::Matrix3d::Ones();  // the homography is the stronger statement
  const Eigen::VectorXd distances = TruthDistances(problem, truth);
  CHECK(distances[0] == Approx(0.0).margin(1e-12));
  CHECK(distances[1] == Approx(4.0));
  CHECK(std::isinf(distances[2]));
}

TEST_CASE("E and F follow from each other and the calibration") {
  const Example pair = SyntheticSet(1, 4, Rng(3)).pairs[0];
  GroundTruth from_fundamental;
  from_fundamental.fundamental = pair.truth.fundamental;
  CompleteTruth(pair.problem, &from_fundamental);
  CHECK(from_fundamental.essential->isApprox(*pair.truth.essential, 1e-9));
  Problem uncalibrated;
  GroundTruth alone;
  alone.fundamental = pair.truth.fundamental;
  CompleteTruth(uncalibrated, &alone);
  CHECK(!alone.essential);
}

TEST_CASE("a pair becomes a problem of each task, with the truth that is known") {
  const Example pair = SyntheticSet(1, 60, Rng(3)).pairs.front();
  for (const Task task : {Task::kFundamental, Task::kEssential, Task::kHomography}) {
    CAPTURE(ToString(task));
    Example example = pair;
    SetTask(task, 2.0, &example);
    CHECK(example.problem.task == task);
    CHECK(example.problem.inlier_threshold == 2.0);
    CHECK(example.problem.points == pair.problem.points);
    CHECK((example.truth.model.size() == 9) == (task != Task::kHomography));
    CHECK(example.truth.pose->translation.norm() == Approx(1.0));
    for (int k = 0; k < 60; ++k) CHECK(example.truth.inliers[k] == pair.truth.assignment[k]);
  }
  Example unlabelled = pair;
  unlabelled.truth.assignment.clear();
  SetTask(Task::kEssential, 2.0, &unlabelled);
  const Eigen::VectorXd distances = TruthDistances(pair.problem, pair.truth);
  for (int k = 0; k < 60; ++k) CHECK(unlabelled.truth.inliers[k] == (distances[k] <= 2.0));
  unlabelled.truth = {};
  SetTask(Task::kEssential, 2.0, &unlabelled);
  CHECK(unlabelled.truth.inliers.empty());
  CHECK(!unlabelled.truth.pose);
}

}  // namespace diffsac
