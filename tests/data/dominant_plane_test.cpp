#include "diffsac/data/dominant_plane.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>

#include "data/two_view_test_util.h"
#include "diffsac/data/two_view_dataset.h"

namespace diffsac {
namespace {

constexpr int kOnPlane = 60, kElsewhere = 40, kWrong = 30;

// Two views of a plane, of points off it, and wrong matches.
TwoViewExample PlanePair() {
  Rng rng(11);
  TwoViewExample pair;
  pair.scene = "scene";
  pair.id = "a-b";
  pair.problem.calibrated = true;
  pair.problem.K1 = pair.problem.K2 = Calibration(500, 500, 320, 240);
  RigidMotion motion;
  motion.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d(0.2, 1, 0.1).normalized()).toRotationMatrix();
  motion.translation = Eigen::Vector3d(0.4, 0.05, 0.1);
  pair.truth.motion = motion;
  pair.problem.points.resize(kOnPlane + kElsewhere + kWrong, 4);
  for (int i = 0; i < pair.problem.points.rows(); ++i) {
    const double x = rng.Uniform(-1.0, 1.0), y = rng.Uniform(-1.0, 1.0);
    const double depth = i < kOnPlane ? 4.0 + 0.3 * x : rng.Uniform(2.0, 12.0);
    const Eigen::Vector3d point(x, y, depth);
    const Eigen::Vector2d first = Project(pair.problem.K1, {}, point);
    Eigen::Vector2d second = Project(pair.problem.K2, motion, point);
    if (i >= kOnPlane + kElsewhere) second = Eigen::Vector2d(rng.Uniform(0, 640), rng.Uniform(0, 480));
    pair.problem.points.row(i) << first.transpose(), second.transpose();
  }
  CompleteTruth(pair.problem, &pair.truth);
  return pair;
}

}  // namespace

TEST_CASE("the dominant plane's homography is the truth of pairs that have a pose alone") {
  const TwoViewExample pair = PlanePair();
  const auto homography = DominantHomography(pair.problem, pair.truth, 1.0, "a");
  REQUIRE(homography);
  CHECK(*homography == *DominantHomography(pair.problem, pair.truth, 1.0, "a"));
  CorrespondencesOptions options;
  CHECK(ToExample(pair, Task::kHomography, options).truth.model.size() == 0);
  options.dominant_plane = true;
  const Example example = ToExample(pair, Task::kHomography, options);
  REQUIRE(example.truth.model.size() == 9);
  const auto& inliers = example.truth.inliers;
  CHECK(std::all_of(inliers.begin(), inliers.begin() + kOnPlane, [](auto inlier) { return inlier != 0; }));
  CHECK(std::count(inliers.begin() + kOnPlane, inliers.end(), 1) < 12);
  CHECK(example.truth.pose);
}

TEST_CASE("without a plane that enough matches follow a homography has no truth") {
  TwoViewExample pair = PlanePair();
  pair.problem.points = PointMatrix(pair.problem.points.bottomRows(kElsewhere + kWrong));
  const auto homography = DominantHomography(pair.problem, pair.truth, 0.05, "a");
  CHECK_FALSE(homography);
  pair.problem.points.conservativeResize(3, 4);
  CHECK_FALSE(DominantHomography(pair.problem, pair.truth, 1.0, "a"));
  CorrespondencesOptions options;
  options.dominant_plane = true;
  CHECK(ToExample(pair, Task::kHomography, options).truth.inliers.empty());
}

}  // namespace diffsac
