#include "lab/data/dominant_plane.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/temporary_folder.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/correspondences_dataset.h"
#include "lab/data/two_view_test_util.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {
namespace {

constexpr int kOnPlane = 60, kElsewhere = 40, kWrong = 30;

// Two views of a plane, of points off it, and wrong matches.
Example PlanePair() {
  Rng rng(11);
  Example pair;
  pair.scene = "scene";
  pair.image1 = "a";
  pair.image2 = "b";
  pair.id = "a-b";
  const Eigen::Matrix3d K = Calibration(500, 500, 320, 240);
  pair.problem.cameras = CameraPair{K, K};
  RigidMotion motion;
  motion.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d(0.2, 1, 0.1).normalized()).toRotationMatrix();
  motion.translation = Eigen::Vector3d(0.4, 0.05, 0.1);
  pair.truth.motion = motion;
  pair.problem.points.resize(kOnPlane + kElsewhere + kWrong, 4);
  for (int i = 0; i < pair.problem.points.rows(); ++i) {
    const double x = rng.Uniform(-1.0, 1.0), y = rng.Uniform(-1.0, 1.0);
    const double depth = i < kOnPlane ? 4.0 + 0.3 * x : rng.Uniform(2.0, 12.0);
    const Eigen::Vector3d point(x, y, depth);
    const Eigen::Vector2d first = Project(K, {}, point);
    Eigen::Vector2d second = Project(K, motion, point);
    if (i >= kOnPlane + kElsewhere) second = Eigen::Vector2d(rng.Uniform(0, 640), rng.Uniform(0, 480));
    pair.problem.points.row(i) << first.transpose(), second.transpose();
  }
  CompleteTruth(pair.problem, &pair.truth);
  return pair;
}

// The pair as a dataset of homographies gives it.
Example Read(const Example& pair, bool dominant_plane) {
  const TemporaryFolder folder;
  CorrespondenceSet set;
  set.pairs = {pair};
  set.cameras = {{"a", {}}, {"b", *pair.truth.motion}};
  WriteCorrespondences(folder / "scene", set);
  CorrespondencesOptions options;
  options.paths = {folder / "scene"};
  options.pairs.task = Task::kHomography;
  options.pairs.dominant_plane = dominant_plane;
  return MakeCorrespondences(options, 1)->Get(0);
}

}  // namespace

TEST_CASE("the dominant plane's homography is the truth of pairs that have a pose alone") {
  const Example pair = PlanePair();
  const auto homography = DominantHomography(pair.problem, pair.truth, 1.0, "a");
  REQUIRE(homography);
  CHECK(*homography == *DominantHomography(pair.problem, pair.truth, 1.0, "a"));
  CHECK(Read(pair, false).truth.model.size() == 0);
  const Example example = Read(pair, true);
  REQUIRE(example.truth.model.size() == 9);
  const auto& inliers = example.truth.inliers;
  CHECK(std::all_of(inliers.begin(), inliers.begin() + kOnPlane, [](auto inlier) { return inlier != 0; }));
  CHECK(std::count(inliers.begin() + kOnPlane, inliers.end(), 1) < 12);
  CHECK(example.truth.pose);
}

TEST_CASE("without a plane that enough matches follow a homography has no truth") {
  Example pair = PlanePair();
  pair.problem.points = PointMatrix(pair.problem.points.bottomRows(kElsewhere + kWrong));
  const auto homography = DominantHomography(pair.problem, pair.truth, 0.05, "a");
  CHECK_FALSE(homography);
  pair.problem.points.conservativeResize(3, 4);
  CHECK_FALSE(DominantHomography(pair.problem, pair.truth, 1.0, "a"));
  CHECK(Read(pair, true).truth.inliers.empty());
}

}  // namespace diffsac
