#include "diffsac/estimate/error_probability.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/diffsac.h"
#include "estimate/owned_matches.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

const Eigen::Matrix3d kCamera{{1000.0, 0.0, 640.0}, {0.0, 1000.0, 480.0}, {0.0, 0.0, 1.0}};

/// Matches of a wavy surface, seen by a camera that moved; the last `wrong` of them are anywhere.
testing::OwnedMatches Views(int right, int wrong, int seed) {
  Rng rng(seed);
  const RelativePose pose = testing::RandomPose(rng, 0.2);
  testing::OwnedMatches matches;
  const int count = right + wrong;
  matches.points1.resize(count, 2);
  matches.points2.resize(count, 2);
  const auto anywhere = [&] { return Eigen::RowVector2d(rng.Uniform(0.0, 1280.0), rng.Uniform(0.0, 960.0)); };
  for (int i = 0; i < count; ++i) {
    matches.points1.row(i) = anywhere();
    const Eigen::Vector3d ray = kCamera.inverse() * matches.points1.row(i).transpose().homogeneous();
    const double depth = 6.0 + std::sin(6.0 * ray.x()) + std::sin(8.0 * ray.y());
    const Eigen::Vector3d seen = kCamera * (pose.rotation * ray * depth + 0.5 * pose.translation);
    matches.points2.row(i) = i < right ? Eigen::RowVector2d(seen.hnormalized().transpose()) : anywhere();
    for (int k = 0; k < 2; ++k) matches.points2(i, k) += 0.5 * rng.Normal();
  }
  return matches;
}

TwoViewEstimate Find(const testing::OwnedMatches& matches) {
  ImageOptions options;
  options.guidance = Guidance::kNone;
  return EstimateFundamental(matches, options);
}

}  // namespace

TEST_CASE("clear models are likely right") {
  for (int seed = 0; seed < 5; ++seed) {
    const TwoViewEstimate clear = Find(Views(300, 50, seed)), chance = Find(Views(8, 200, seed));
    CAPTURE(seed, clear.diagnostics.error_probability, chance.diagnostics.error_probability);
    REQUIRE(clear.ok());
    CHECK(clear.diagnostics.error_probability < 0.2);
    CHECK_FALSE(testing::MayBeWrong(clear));
    if (!chance.ok()) continue;
    CHECK(chance.diagnostics.error_probability > 2.0 * clear.diagnostics.error_probability);
    CHECK(testing::MayBeWrong(chance));
  }
}

TEST_CASE("a mirrored photograph is told") {
  int told = 0;
  for (int seed = 0; seed < 6; ++seed) {
    testing::OwnedMatches matches = Views(200, 100, seed);
    ImageOptions options;
    options.guidance = Guidance::kNone;
    CHECK_FALSE(EstimateEssential(matches, {kCamera, kCamera}, options).diagnostics.mirrored);
    matches.points2.col(0) = 1279.0 - matches.points2.col(0).array();
    const TwoViewEstimate estimate = EstimateEssential(matches, {kCamera, kCamera}, options);
    told += estimate.diagnostics.mirrored;
    if (!estimate.diagnostics.mirrored) continue;
    CHECK(testing::MayBeChance(estimate));
    CHECK_FALSE(estimate.pose_covariance);
    CHECK(estimate.diagnostics.degeneracy == Degeneracy::kNotTested);
  }
  CHECK(told >= 4);
  CHECK_FALSE(Find(Views(8, 200, 1)).diagnostics.mirrored);
}

TEST_CASE("the error probability knows no unit") {
  testing::OwnedMatches matches = Views(80, 80, 3);
  const double once = Find(matches).diagnostics.error_probability;
  matches.points1 *= 1e-3;
  matches.points2 *= 1e-3;
  CHECK(Find(matches).diagnostics.error_probability == Approx(once).margin(0.02));
}

TEST_CASE("other tasks have no error probability") {
  const testing::OwnedMatches matches = Views(80, 10, 1);
  CHECK(std::isnan(EstimateHomography(matches).diagnostics.error_probability));
  testing::OwnedMatches none;
  CHECK(std::isnan(Find(none).diagnostics.error_probability));
}

}  // namespace diffsac
