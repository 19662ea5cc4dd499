#include "diffsac/geometry/photographs.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/geometry/epipolar.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

const PhotographPriors kSameCamera{{{{1.2, 0.43}, {1.2, 0.43}}}, true};

/// Matches of two cameras of one focal length, in its unit, with normal noise.
struct Photographs {
  PhotographPair truth;
  NearMatches matches;
};

Photographs MakePhotographs(int count, double noise, const Eigen::Vector4d& principal_points, Rng& rng) {
  const double focal = rng.Uniform(0.8, 1.6);
  const testing::TwoViewProblem views = testing::RandomProblem(count, rng);
  Photographs made;
  made.truth = {AsFocalParameters(views.essential, focal, focal), principal_points};
  made.matches = {
      focal * views.normalized, Eigen::VectorXd::Ones(count), {LossKind::kTruncated, 0.05}, noise * noise + 1e-12};
  made.matches.points.rowwise() += principal_points.transpose();
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < 4; ++j) made.matches.points(i, j) += noise * rng.Normal();
  return made;
}

double ErrorOf(const PhotographPair& pair, const Photographs& made) {
  return testing::ModelDistance(FundamentalOf(pair).normalized(), FundamentalOf(made.truth).normalized());
}

PhotographPair Disturbed(PhotographPair pair, Rng& rng) {
  for (int i = 0; i < 9; ++i) pair.model[i] += 0.02 * rng.Normal();
  pair.model.tail<2>() *= std::exp(rng.Uniform(-0.2, 0.2));
  pair.principal_points.setZero();
  return pair;
}

}  // namespace

TEST_CASE("photographs' cameras are found from near by") {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    const Photographs made = MakePhotographs(100, 0.0, Eigen::Vector4d::Zero(), rng);
    PhotographPair pair = Disturbed(made.truth, rng);
    REQUIRE(std::isfinite(RefinePhotographs(made.matches, kSameCamera, &pair)));
    CHECK(ErrorOf(pair, made) < 1e-3);
  }
}

TEST_CASE("principal points far from the middle are found") {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    const Photographs made = MakePhotographs(200, 0.0, {0.2, 0.0, 0.2, 0.0}, rng);
    PhotographPair pair = Disturbed(made.truth, rng);
    RefinePhotographs(made.matches, kSameCamera, &pair);
    found += ErrorOf(pair, made) < 1e-3;
  }
  CHECK(found >= 8);
}

TEST_CASE("likelier cameras have a lower cost") {
  Rng rng(5);
  const Photographs made = MakePhotographs(100, 1e-3, Eigen::Vector4d::Zero(), rng);
  PhotographPair first = Disturbed(made.truth, rng), second = first;
  const double cost = RefinePhotographs(made.matches, kSameCamera, &first);
  PhotographPriors elsewhere = kSameCamera;
  elsewhere.focals[0].focal = elsewhere.focals[1].focal = 20.0;
  CHECK(RefinePhotographs(made.matches, elsewhere, &second) > cost);
}

TEST_CASE("no photographs without matches") {
  PhotographPair pair{AsFocalParameters(Matrix3Parameters::Unit(5) - Matrix3Parameters::Unit(7), 1.0, 1.0)};
  const PhotographPair before = pair;
  NearMatches none;
  none.variance = 1.0;
  CHECK(std::isfinite(RefinePhotographs(none, kSameCamera, &pair)));
  CHECK(FundamentalOf(pair).allFinite());
  CHECK(FundamentalOf(before).allFinite());
}

}  // namespace diffsac
