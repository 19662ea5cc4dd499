// A motion ahead of two unknown focal lengths may go the other way.
#include <catch2/catch.hpp>

#include "diffsac/diffsac.h"
#include "estimate/owned_matches.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

constexpr int kSeeds = 40, kMatches = 150;

struct Views {
  testing::OwnedMatches matches;
  RelativePose pose;
};

/// Images of two focal lengths from either end of a baseline that is a tenth of the depth, with a pixel of noise.
Views MakeViews(std::uint64_t seed, bool ahead) {
  Rng rng = Rng(70).Fork("zoom", seed);
  const double focal1 = rng.Uniform(800.0, 1300.0), focal2 = focal1 * std::exp(rng.Uniform(-0.3, 0.3));
  Views made;
  made.pose = testing::RandomPose(rng, 0.07);
  const double across = rng.Uniform(0.0, 0.3), turn = rng.Uniform(0.0, 6.3),
               sign = rng.Uniform(0.0, 1.0) < 0.5 ? -1 : 1;
  made.pose.translation = ahead ? Eigen::Vector3d(across * std::cos(turn), across * std::sin(turn), sign)
                                : Eigen::Vector3d(std::cos(turn), std::sin(turn), 0.3 * sign);
  PointMatrix points(kMatches, 4);
  for (int i = 0; i < kMatches;) {
    const double depth = rng.Uniform(7.0, 14.0);
    const Eigen::Vector3d first(depth * rng.Uniform(-0.4, 0.4), depth * rng.Uniform(-0.3, 0.3), depth),
        second = made.pose.rotation * first + made.pose.translation;
    points.row(i) << focal1 * first.hnormalized().transpose(), focal2 * second.hnormalized().transpose();
    if (points.row(i).cwiseAbs().maxCoeff() > 370.0) continue;
    for (int j = 0; j < 4; ++j) points(i, j) += 374.5 + rng.Normal();
    ++i;
  }
  made.matches.points1 = points.leftCols(2);
  made.matches.points2 = points.rightCols(2);
  made.matches.size1 = made.matches.size2 = {750, 750};
  return made;
}

double DegreesOff(const RigidMotion& motion, const Views& made) {
  return DirectionAngleDegrees(motion.translation, made.pose.translation);
}

}  // namespace

TEST_CASE("motions ahead of unknown zoom have both directions") {
  int reversed = 0, told = 0, held = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Views made = MakeViews(seed, true);
    const UnknownFocalEstimate found = EstimateTwoFocals(made.matches);
    REQUIRE(found.pose);
    const bool wrong = DegreesOff(*found.pose, made) > 60.0;
    reversed += wrong;
    told += found.ambiguous_pose.has_value();
    if (found.ambiguous_pose) CHECK(found.verdict != Verdict::kReliable);
    held += !wrong || (found.ambiguous_pose && DegreesOff(*found.ambiguous_pose, made) < 60.0);
  }
  CAPTURE(reversed, told, held);
  CHECK(reversed > 0);
  CHECK(told >= reversed);
  CHECK(held >= kSeeds - 2);
}

TEST_CASE("motions across have one direction") {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
    CHECK_FALSE(EstimateTwoFocals(MakeViews(seed, false).matches).ambiguous_pose);
}

TEST_CASE("one focal length leaves one direction ahead") {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
    CHECK_FALSE(EstimateSharedFocal(MakeViews(seed, true).matches).ambiguous_pose);
}

}  // namespace diffsac
