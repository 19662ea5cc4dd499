// What estimates say of a translation, or a model, that the matches leave open.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/core/random.h"
#include "diffsac/diffsac.h"
#include "diffsac/geometry/pose.h"
#include "estimate/owned_matches.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

const Eigen::Matrix3d kCamera = (Eigen::Matrix3d() << 1000, 0, 960, 0, 1000, 540, 0, 0, 1).finished();

struct Views {
  testing::OwnedMatches matches;
  RelativePose pose;
};

struct Scene {
  int count = 300;
  double noise = 0.5, wrong = 0.05, degrees = 12.0, baseline = 0.0;
  bool plane = false;
};

bool IsSeen(const Eigen::Vector3d& pixel) {
  const Eigen::Array2d seen = pixel.hnormalized();
  return pixel.z() > 0.0 && (seen >= 0.0).all() && seen.x() <= 1920.0 && seen.y() <= 1080.0;
}

/// Of 1920 × 1080 pixels; points are half a unit to two away.
Views Make(const Scene& scene, std::uint64_t seed) {
  Rng rng(seed);
  Views views;
  views.pose.rotation =
      Eigen::AngleAxisd(scene.degrees * 0.017453292519943295, testing::RandomDirection(rng)).toRotationMatrix();
  views.pose.translation = testing::RandomDirection(rng);
  views.matches.size1 = views.matches.size2 = {1920, 1080};
  views.matches.points1.resize(scene.count, 2);
  views.matches.points2.resize(scene.count, 2);
  const Eigen::Vector3d normal(rng.Uniform(-0.3, 0.3), rng.Uniform(-0.3, 0.3), 1.0);
  for (int i = 0; i < scene.count; ++i) {
    Eigen::Vector2d pixel;
    Eigen::Vector3d second;
    do {  // Both images show it.
      pixel << rng.Uniform(0.0, 1920.0), rng.Uniform(0.0, 1080.0);
      const Eigen::Vector3d ray = kCamera.inverse() * pixel.homogeneous();
      const double depth = scene.plane ? 1.0 / normal.dot(ray) : rng.Uniform(0.5, 2.0);
      second = kCamera * (views.pose.rotation * ray * depth + scene.baseline * views.pose.translation);
    } while (!IsSeen(second));
    views.matches.points1.row(i) = pixel.transpose();
    views.matches.points2.row(i) = second.hnormalized().transpose();
    if (i < scene.wrong * scene.count)
      views.matches.points2.row(i) << rng.Uniform(0.0, 1920.0), rng.Uniform(0.0, 1080.0);
    for (int j = 0; j < 2; ++j) {
      views.matches.points1(i, j) += scene.noise * rng.Normal();
      views.matches.points2(i, j) += scene.noise * rng.Normal();
    }
  }
  return views;
}

ImageOptions Plain() {
  ImageOptions options;
  options.guidance = Guidance::kNone;
  return options;
}

/// How many of `seeds` estimates say this.
template <class EstimateViews>
int Told(const Scene& scene, Degeneracy translation, int seeds, const EstimateViews& estimate) {
  int told = 0;
  for (int seed = 0; seed < seeds; ++seed) told += estimate(Make(scene, seed)).diagnostics.degeneracy == translation;
  return told;
}

TwoViewEstimate Essentials(const Views& views) { return EstimateEssential(views.matches, {kCamera, kCamera}, Plain()); }
TwoViewEstimate Fundamentals(const Views& views) { return EstimateFundamental(views.matches, Plain()); }

UnknownFocalEstimate SharedFocals(const Views& views) {
  FocalOptions options;
  return EstimateSharedFocal(views.matches, options);
}

UnknownFocalEstimate OneFocals(const Views& views) {
  FocalOptions options;
  return EstimateOneFocal(views.matches, kCamera, options);
}

}  // namespace

// t of a camera that only turned, said to be certain to a few degrees.
TEST_CASE("an essential matrix of a pure rotation says so at every noise, and its R is better than E's") {
  int told = 0;
  double turn = 0.0, of_model = 0.0;
  for (const double noise : {0.0, 0.2, 0.35, 0.5, 1.0, 2.0})
    for (const int count : {20, 100, 500})
      for (int seed = 0; seed < 5; ++seed) {
        const Views views = Make({count, noise, 0.05}, seed);
        const TwoViewEstimate estimate = Essentials(views);
        REQUIRE(estimate.ok());
        if (estimate.diagnostics.degeneracy != Degeneracy::kPureRotation) continue;
        ++told;
        CHECK_FALSE(estimate.pose_covariance);
        REQUIRE(estimate.pose);
        CHECK(estimate.pose->translation.isZero(0.0));
        PointMatrix points(count, 4);
        points << views.matches.points1, views.matches.points2;
        turn += RotationAngleDegrees(estimate.pose->rotation, views.pose.rotation);
        of_model += RotationAngleDegrees(
            ChoosePose(estimate.model, NormalizedCoordinates(points, kCamera, kCamera), estimate.inliers).pose.rotation,
            views.pose.rotation);
      }
  CHECK(told >= 89);
  CHECK(turn < 0.8 * of_model);
}

TEST_CASE("a camera that moved has a translation, at a hundredth of the scene's depth too") {
  for (const double noise : {0.1, 0.5, 1.0}) {
    CHECK(Told({300, noise, 0.05, 5.0, 0.01}, Degeneracy::kDetermined, 10, Essentials) >= 9);
    CHECK(Told({60, noise, 0.05, 5.0, 0.3}, Degeneracy::kDetermined, 10, Essentials) == 10);
    CHECK(Told({300, noise, 0.05, 5.0, 0.3}, Degeneracy::kDetermined, 5, Fundamentals) == 5);
    CHECK(Told({300, noise, 0.05, 5.0, 0.3}, Degeneracy::kDetermined, 5, SharedFocals) == 5);
    for (int seed = 0; seed < 5; ++seed) {
      // Of a plane's two motions the wrong one may leave points behind the camera: then there is no verdict.
      const TwoViewEstimate of_plane = Essentials(Make({300, noise, 0.05, 5.0, 0.3, true}, seed));
      CAPTURE(noise, seed, of_plane.diagnostics.cheirality_failure_ratio);
      CHECK((of_plane.diagnostics.degeneracy == Degeneracy::kDetermined ||
             of_plane.diagnostics.cheirality_failure_ratio > kMostBehind));
    }
  }
}

// Of little parallax the noise along epipolar lines was taken for it, and σ of t came out a third of what it is.
// The right matches are the same with 1 wrong one for each as with 20, and so is what they show.
TEST_CASE("wrong matches never make a turn of parallax") {
  const auto moved = [](const auto& estimate_views, double noise, int wrong_for_each, int seed) {
    const int right = 60, count = right * (1 + wrong_for_each);
    Views views = Make({count, noise, 1.0 - 1.0 / (1 + wrong_for_each), 5.0, 0.3}, seed);
    Rng rng(seed);
    views.matches.snn_ratio.resize(count);
    for (int i = 0; i < count; ++i)
      views.matches.snn_ratio[i] = i < count - right ? rng.Uniform(0.6, 1.0) : rng.Uniform(0.3, 0.9);
    const auto estimate = estimate_views(views);
    return !estimate.ok() || testing::MayBeChance(estimate) ||
           estimate.diagnostics.degeneracy == Degeneracy::kDetermined;
  };
  for (const double noise : {0.1, 0.5, 1.0})
    for (const int wrong_for_each : {1, 3, 8, 20}) {
      int right[3] = {0, 0, 0};
      for (int seed = 0; seed < 5; ++seed) {
        right[0] += moved(Essentials, noise, wrong_for_each, seed);
        right[1] += moved(Fundamentals, noise, wrong_for_each, seed);
        right[2] += moved(SharedFocals, noise, wrong_for_each, seed);
      }
      CAPTURE(noise, wrong_for_each);
      CHECK(right[0] == 5);
      CHECK(right[1] == 5);
      CHECK(right[2] == 5);
    }
}

TEST_CASE("turns and still cameras among wrong matches") {
  int all = 0, turns = 0, still = 0, planes = 0;
  for (const double wrong : {0.0, 0.5, 0.8})
    for (const double noise : {0.1, 0.5, 1.0})
      for (int seed = 0; seed < 5; ++seed) {
        const int count = static_cast<int>(100 / (1.0 - wrong));
        const auto told = [](const auto& estimate, Degeneracy translation) {
          return testing::MayBeChance(estimate) || estimate.diagnostics.degeneracy == translation;
        };
        ++all;
        turns += told(Essentials(Make({count, noise, wrong, 8.0}, seed)), Degeneracy::kPureRotation);
        still += told(Essentials(Make({count, noise, wrong, 0.0}, seed)), Degeneracy::kStatic);
        planes += told(Fundamentals(Make({count, noise, wrong, 5.0, 0.3, true}, seed)), Degeneracy::kPlane);
      }
  CAPTURE(all, turns, still, planes);
  CHECK(turns >= 0.95 * all);
  CHECK(still >= 0.95 * all);
  CHECK(planes >= 0.95 * all);
}

TEST_CASE("what may be chance has no verdict") {
  for (int seed = 0; seed < 10; ++seed) {
    const TwoViewEstimate estimate = Essentials(Make({200, 0.5, 1.0, 5.0, 0.3}, seed));
    if (!estimate.ok() || !testing::MayBeChance(estimate)) continue;
    CHECK(estimate.diagnostics.degeneracy == Degeneracy::kNotTested);
    CHECK_FALSE(estimate.pose_covariance);
    CHECK(testing::MayBeWrong(estimate));
  }
}

TEST_CASE("where the parallax is hardly more than the noise, the covariance says so") {
  int within = 0, all = 0;
  for (int seed = 0; seed < 240; ++seed) {
    const Views views = Make({300, 0.5, 0.0, 5.0, 0.004}, seed);
    const TwoViewEstimate estimate = Essentials(views);
    if (!estimate.pose_covariance) continue;
    ++all;
    const double sigma = std::sqrt(estimate.pose_covariance->block<3, 3>(3, 3).trace() / 2.0);
    const double error = DirectionAngleDegrees(estimate.pose->translation, views.pose.translation);
    within += error * 0.017453292519943295 < 2.45 * sigma;
  }
  CHECK(all >= 200);
  CHECK(within >= 0.82 * all);
}

TEST_CASE("the same image twice, and a still camera, show no motion") {
  for (const double noise : {0.0, 0.5, 1.0}) {
    CHECK(Told({200, noise, 0.05, 0.0}, Degeneracy::kStatic, 10, Essentials) >= 9);
    CHECK(Told({200, noise, 0.05, 0.0}, Degeneracy::kStatic, 5, Fundamentals) >= 4);
    CHECK(Told({200, noise, 0.05, 0.0}, Degeneracy::kStatic, 5, SharedFocals) >= 4);
  }
}

// F of a plane or of a turn came back without a word.
TEST_CASE("a fundamental matrix of a plane, or of a turn, says that it is one of many") {
  for (const double noise : {0.2, 1.0, 2.0}) {
    CHECK(Told({200, noise, 0.05, 5.0, 0.3, true}, Degeneracy::kPlane, 10, Fundamentals) >= 9);
    CHECK(Told({200, noise, 0.05, 12.0}, Degeneracy::kPlane, 10, Fundamentals) >= 9);
  }
}

TEST_CASE("a pure rotation is told without the focal length, or with that of one image") {
  int shared = 0, one = 0;
  for (const double noise : {0.2, 1.0}) {
    shared += Told({200, noise, 0.05, 12.0}, Degeneracy::kPureRotation, 20, SharedFocals);
    one += Told({200, noise, 0.05, 12.0}, Degeneracy::kPureRotation, 20, OneFocals);
  }
  CHECK(shared >= 36);
  CHECK(one >= 36);
}

// H of points on a line came back without a word.
TEST_CASE("a homography of points on one line, and two beside it, says that it is one of many") {
  for (const int beside : {0, 1, 2, 12})
    for (int seed = 0; seed < 5; ++seed) {
      Views views = Make({100, 0.0, 0.0, 5.0, 0.3, true}, seed);
      Rng rng(100 + seed);
      const Eigen::Vector2d start(100, 200), end(1800, 900);
      // On the plane, so that the true homography takes the line along.
      Eigen::MatrixX2d first = views.matches.points1, second = views.matches.points2;
      Views whole = views;
      const Eigen::Matrix3d h = EstimateHomography(whole.matches, Plain()).model;
      for (int i = beside; i < 100; ++i) {
        first.row(i) = (start + rng.Uniform() * (end - start)).transpose();
        second.row(i) = (h * first.row(i).transpose().homogeneous()).hnormalized().transpose();
      }
      for (Eigen::Index i = 0; i < first.size(); ++i) {
        first.data()[i] += 0.3 * rng.Normal();
        second.data()[i] += 0.3 * rng.Normal();
      }
      views.matches.points1 = first;
      views.matches.points2 = second;
      views.matches.size2 = {};  // The line leaves it.
      const TwoViewEstimate estimate = EstimateHomography(views.matches, Plain());
      if (!estimate.ok()) continue;
      CAPTURE(beside, seed, estimate.diagnostics.mirrored, estimate.diagnostics.log10_nfa);
      CHECK(estimate.diagnostics.degeneracy == (beside < 3 ? Degeneracy::kLine : Degeneracy::kDetermined));
    }
}

// A watermark on both images, or dirt on the lens: E = [t]ₓ with any t explains it, and part of the scene.
TEST_CASE("what stands still on the images does not outvote a scene of fewer matches") {
  for (const double degrees : {1.0, 5.0})
    for (const int scene : {30, 60, 100}) {
      constexpr int kOverlay = 100;
      Views views = Make({scene, 0.5, 0.0, degrees, 0.3}, 3);
      Rng rng(9);
      testing::OwnedMatches& matches = views.matches;
      matches.points1.conservativeResize(scene + kOverlay, 2);
      matches.points2.conservativeResize(scene + kOverlay, 2);
      for (int i = scene; i < scene + kOverlay; ++i)
        matches.points1.row(i) = matches.points2.row(i) =
            Eigen::RowVector2d(rng.Uniform(0.0, 1920.0), rng.Uniform(0.0, 1080.0));
      const TwoViewEstimate estimate = Essentials(views);
      REQUIRE(estimate.ok());
      CAPTURE(degrees, scene);
      CHECK(estimate.diagnostics.degeneracy == Degeneracy::kDetermined);
      REQUIRE(static_cast<int>(estimate.inliers.size()) == scene + kOverlay);
      CHECK(std::count(estimate.inliers.begin(), estimate.inliers.begin() + scene, 1) >= 0.9 * scene);
      CHECK(RotationAngleDegrees(estimate.pose->rotation, views.pose.rotation) < 0.2);
      matches.points1 = Eigen::MatrixX2d(matches.points1.bottomRows(kOverlay));
      matches.points2 = Eigen::MatrixX2d(matches.points2.bottomRows(kOverlay));
      CHECK(Essentials(views).diagnostics.degeneracy == Degeneracy::kStatic);
    }
}

TEST_CASE("a watermark on images of a camera that turned gave a certain translation") {
  Scene scene{.count = 200, .noise = 0.5, .wrong = 0.0};
  int turns = 0;
  for (int seed = 0; seed < 10; ++seed) {
    Views views = Make(scene, seed);
    Rng rng(100 + seed);
    Eigen::Matrix<double, Eigen::Dynamic, 2> mark(40, 2);
    for (int i = 0; i < 40; ++i) mark.row(i) << rng.Uniform(0.0, 1920.0), rng.Uniform(0.0, 1080.0);
    for (auto* points : {&views.matches.points1, &views.matches.points2}) {
      points->conservativeResize(240, Eigen::NoChange);
      points->bottomRows(40) = mark;
    }
    const TwoViewEstimate estimate = Essentials(views);
    turns += estimate.diagnostics.degeneracy == Degeneracy::kPureRotation && !estimate.pose_covariance;
  }
  CHECK(turns >= 9);
}

TEST_CASE("one image twice has no fundamental matrix, and says why") {
  Views views = Make({}, 3);
  views.matches.points2 = views.matches.points1;
  CHECK(Fundamentals(views).diagnostics.degeneracy == Degeneracy::kStatic);
}

TEST_CASE("far points, whose side noise decides, reversed t against a few near ones") {
  for (int seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.14, Eigen::Vector3d::UnitY()).toRotationMatrix();
    testing::OwnedMatches matches;
    matches.points1.resize(200, 2);
    matches.points2.resize(200, 2);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d pixel(rng.Uniform(20.0, 1900.0), rng.Uniform(20.0, 1060.0), 1.0);
      const double depth = i < 50 ? rng.Uniform(4.0, 10.0) : rng.Uniform(1e4, 1e5);
      const Eigen::Vector3d seen = kCamera * (turn * (depth * (kCamera.inverse() * pixel)) + Eigen::Vector3d::UnitX());
      matches.points1.row(i) << pixel.x() + 0.5 * rng.Normal(), pixel.y() + 0.5 * rng.Normal();
      matches.points2.row(i) = seen.hnormalized().transpose();
      for (int j = 0; j < 2; ++j) matches.points2(i, j) += 0.5 * rng.Normal();
    }
    const TwoViewEstimate estimate = EstimateEssential(matches, {kCamera, kCamera}, Plain());
    REQUIRE(estimate.pose);
    CHECK(estimate.pose->translation.x() > 0.9);
  }
}

TEST_CASE("what has no translation is not asked for one") {
  const Views views = Make({100, 0.5, 0.1, 5.0, 0.3, true}, 1);
  CHECK(EstimateHomography(views.matches, Plain()).diagnostics.degeneracy == Degeneracy::kDetermined);
  testing::OwnedMatches few = views.matches;
  few.points1.conservativeResize(4, 2);
  few.points2.conservativeResize(4, 2);
  CHECK(EstimateEssential(few, {kCamera, kCamera}, Plain()).diagnostics.degeneracy == Degeneracy::kNotTested);
}

}  // namespace diffsac
