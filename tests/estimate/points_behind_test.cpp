// What fits a motion but lies behind its cameras.

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "diffsac/diffsac.h"
#include "estimate/owned_matches.h"
#include "geometry/two_view_problems.h"
#include "ransac/absolute_pose_scene.h"

namespace diffsac {
namespace {

const Eigen::Matrix3d kCamera{{900.0, 0.0, 500.0}, {0.0, 900.0, 400.0}, {0.0, 0.0, 1.0}};

ImageOptions Plain() {
  ImageOptions options;
  options.guidance = Guidance::kNone;
  return options;
}

/// Matches of one camera that moves to the side, and by `other` elsewhere, with noise of .3 px. The last `behind` are
/// of points behind both.
testing::OwnedMatches Views(int index, int count, int behind, double distance = 1.0, double other = 0.2) {
  Rng rng = Rng(21).Fork("views", index);
  const RelativePose pose{Eigen::AngleAxisd(0.5 * other, testing::RandomDirection(rng)).toRotationMatrix(),
                          Eigen::Vector3d(1.0, other * rng.Normal(), other * rng.Normal()).normalized()};
  testing::OwnedMatches matches;
  matches.points1.resize(count, 2);
  matches.points2.resize(count, 2);
  for (int i = 0; i < count; ++i) {
    const double depth = distance * rng.Uniform(3.0, 9.0) * (i < count - behind ? 1.0 : -1.0);
    const Eigen::Vector3d x(depth * rng.Uniform(-0.5, 0.5), depth * rng.Uniform(-0.4, 0.4), depth);
    matches.points1.row(i) = (kCamera * x).hnormalized().transpose();
    matches.points2.row(i) = (kCamera * (pose.rotation * x + pose.translation)).hnormalized().transpose();
    for (int k = 0; k < 2; ++k)
      matches.points1(i, k) += 0.3 * rng.Normal(), matches.points2(i, k) += 0.3 * rng.Normal();
  }
  return matches;
}

int Count(const std::vector<std::uint8_t>& mask, int from, int to) {
  return std::accumulate(mask.begin() + from, mask.begin() + to, 0);
}

TEST_CASE("matches of points behind the cameras are no inliers") {
  for (int i = 0; i < 10; ++i) {
    const auto estimate = EstimateEssential(Views(i, 240, 40), {kCamera, kCamera}, Plain());
    CAPTURE(i);
    REQUIRE(estimate.ok());
    CHECK(Count(estimate.inliers, 0, 200) > 190);
    CHECK(Count(estimate.inliers, 200, 240) == 0);
    CHECK(estimate.num_inliers == Count(estimate.inliers, 0, 240));
    CHECK(estimate.diagnostics.cheirality_failure_ratio == Approx(40.0 / 240.0).margin(0.02));
    CHECK_FALSE(testing::MayBeChance(estimate));
  }
}

TEST_CASE("nor of a pose whose focal length is estimated") {
  for (int i = 0; i < 10; ++i) {
    const testing::OwnedMatches matches = Views(i, 240, 40);
    FocalOptions options;
    options.principal_point1 = options.principal_point2 = Eigen::Vector2d(500.0, 400.0);
    options.prior = FocalPrior{900.0, 0.05};
    for (const auto& estimate : {EstimateSharedFocal(matches, options), EstimateOneFocal(matches, kCamera, options)}) {
      CAPTURE(i);
      REQUIRE(estimate.ok());
      CHECK(Count(estimate.inliers, 0, 200) > 180);
      CHECK(Count(estimate.inliers, 200, 240) == 0);
      CHECK(estimate.diagnostics.cheirality_failure_ratio == Approx(40.0 / 240.0).margin(0.03));
    }
  }
}

TEST_CASE("far points stay inliers whose rays cross behind the cameras by noise") {
  for (int i = 0; i < 10; ++i) {
    const testing::OwnedMatches near = Views(i, 100, 0);
    testing::OwnedMatches matches = Views(i, 400, 0, 1e5);
    matches.points1.topRows(100) = near.points1;
    matches.points2.topRows(100) = near.points2;
    const auto estimate = EstimateEssential(matches, {kCamera, kCamera}, Plain());
    CAPTURE(i);
    REQUIRE(estimate.ok());
    CHECK(estimate.diagnostics.cheirality_failure_ratio < 0.005);
    CHECK(Count(estimate.inliers, 100, 400) > 280);
  }
}

TEST_CASE("a mirrored image gives no confident pose") {
  for (int i = 0; i < 10; ++i) {
    // With other motions the mirrored image may be one of yet another, with everything in front.
    testing::OwnedMatches matches = Views(i, 200, 0, 1.0, 0.02);
    matches.points2.col(0) = (1000.0 - matches.points2.col(0).array()).matrix();
    const auto estimate = EstimateEssential(matches, {kCamera, kCamera}, Plain());
    CAPTURE(i, estimate.diagnostics.cheirality_failure_ratio);
    CHECK((!estimate.ok() || testing::MayBeChance(estimate)));
  }
}

testing::OwnedMatches2D3D Scene(int index, int behind) {
  const auto scene = testing::MakeAbsolutePoseScene(200, 0.0, 0.5 / 900.0, Rng(4).Fork("scene", index));
  testing::OwnedMatches2D3D points;
  points.points3d = scene.points.leftCols<3>();
  points.points2d = (scene.points.rightCols<2>() * 900.0).rowwise() + Eigen::RowVector2d(500.0, 400.0);
  // Through the camera's centre, a point behind it has the same image.
  const Eigen::RowVector3d centre = -(RotationOf(scene.truth).transpose() * TranslationOf(scene.truth)).transpose();
  auto last = points.points3d.bottomRows(behind);
  last = ((-last).rowwise() + 2.0 * centre).eval();
  return points;
}

TEST_CASE("points behind the camera are no inliers of its pose, and their share is told") {
  for (int i = 0; i < 10; ++i) {
    const auto estimate = EstimateAbsolutePose(Scene(i, 40), kCamera);
    CAPTURE(i);
    REQUIRE(estimate.ok());
    CHECK(Count(estimate.inliers, 0, 160) == 160);
    CHECK(Count(estimate.inliers, 160, 200) == 0);
    CHECK(estimate.diagnostics.cheirality_failure_ratio == Approx(0.2));
    CHECK_FALSE(testing::MayBeChance(estimate));
    CHECK(EstimateAbsolutePose(Scene(i, 0), kCamera).diagnostics.cheirality_failure_ratio == 0.0);
  }
}

TEST_CASE("a mirrored scene gives no confident pose") {
  for (int i = 0; i < 10; ++i) {
    testing::OwnedMatches2D3D points = Scene(i, 0);
    points.points3d.col(2) *= -1.0;
    const auto estimate = EstimateAbsolutePose(points, kCamera);
    CAPTURE(i, estimate.num_inliers, estimate.diagnostics.cheirality_failure_ratio);
    CHECK((!estimate.ok() || testing::MayBeChance(estimate)));
  }
}

}  // namespace
}  // namespace diffsac
