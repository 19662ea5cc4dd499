// How likely a match is right once the model is known.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/core/random.h"
#include "diffsac/diffsac.h"
#include "estimate/owned_matches.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

struct Labelled {
  PointMatrix points;
  std::vector<bool> right;
  Eigen::VectorXd scores;
};

/// 300 matches of two views or of a plane in images of 1000 × 800, of which a third is right with a noise of .5 pixels.
/// Scores are higher for right ones, and no probabilities.
Labelled Matches300(bool plane, Rng& rng) {
  constexpr int kCount = 300, kRight = 100;
  Labelled made{PointMatrix(kCount, 4), std::vector<bool>(kCount), Eigen::VectorXd(kCount)};
  made.points.topRows(kRight) = plane ? testing::HomographyPoints(testing::RandomHomography(rng), kRight, rng, 0.5)
                                      : testing::RandomProblem(kRight, rng, 0.5).pixels;
  for (int i = 0; i < kCount; ++i) {
    made.right[i] = i < kRight;
    made.scores[i] = std::clamp(0.85 + (made.right[i] ? 0.1 : 0.0) + 0.1 * rng.Normal(), 0.0, 1.0);
    if (!made.right[i])
      made.points.row(i) << rng.Uniform(0, 1000), rng.Uniform(0, 800), rng.Uniform(0, 1000), rng.Uniform(0, 800);
  }
  return made;
}

TwoViewEstimate EstimateOf(bool plane, const Labelled& made, double unit = 1.0) {
  const testing::OwnedMatches matches{
      unit * made.points.leftCols(2), unit * made.points.rightCols(2), {}, {}, {}, {}, made.scores};
  return plane ? EstimateHomography(matches, {}) : EstimateFundamental(matches, {});
}

}  // namespace

TEST_CASE("Posteriors are probabilities, whatever scores mean") {
  for (const bool plane : {false, true}) {
    INFO((plane ? "homography" : "fundamental"));
    std::array<double, 10> said{}, was{};
    double gap = 0.0, all = 0.0;
    for (int trial = 0; trial < 20; ++trial) {
      Rng rng(trial);
      const Labelled made = Matches300(plane, rng);
      const TwoViewEstimate estimate = EstimateOf(plane, made);
      REQUIRE(estimate.posteriors.size() == 300);
      for (int i = 0; i < 300; ++i) {
        const auto bin = std::min<std::size_t>(9, static_cast<std::size_t>(10 * estimate.posteriors[i]));
        said[bin] += estimate.posteriors[i];
        was[bin] += made.right[i];
        all += 1.0;
      }
    }
    for (std::size_t bin = 0; bin < said.size(); ++bin) gap += std::abs(said[bin] - was[bin]);
    CHECK(gap / all < 0.03);
    CHECK(was[9] > 0.5 * all / 3.0);
    CHECK(was[0] < 0.05 * all / 3.0);
  }
}

TEST_CASE("Posteriors do not depend on the unit, of rows that are no matches and without a model they are 0") {
  Rng rng(3);
  Labelled made = Matches300(false, rng);
  const std::vector<float> in_pixels = EstimateOf(false, made).posteriors,
                           larger = EstimateOf(false, made, 64.0).posteriors;
  for (int i = 0; i < 300; ++i) CHECK(larger[i] == Approx(in_pixels[i]).margin(0.02));
  made.points(7, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK(EstimateOf(false, made).posteriors[7] == 0.0F);
  made.points.setConstant(5.0);
  const TwoViewEstimate none = EstimateOf(false, made);
  CHECK_FALSE(none.ok());
  CHECK(none.posteriors == std::vector<float>(300, 0.0F));
}

TEST_CASE("Exact points have certain posteriors") {
  Eigen::Matrix<double, Eigen::Dynamic, 2> points(60, 2);
  Rng rng(1);
  for (int i = 0; i < 60; ++i) points.row(i) << i, i < 40 ? 0.0 : rng.Uniform(5, 60);
  const LineEstimate line = EstimateLine(points, PointOptions{.max_residual = 1.0});
  REQUIRE(line.ok());
  for (int i = 0; i < 60; ++i) CHECK((i < 40 ? line.posteriors[i] > 0.95F : line.posteriors[i] < 0.05F));
}

}  // namespace diffsac
