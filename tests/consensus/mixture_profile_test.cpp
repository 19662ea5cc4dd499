#include "diffsac/consensus/scores/mixture_profile.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

constexpr double kTwoPi = 6.28318530717958647693;

double Of(const MixtureProfile& score, const std::vector<double>& residuals) {
  return score(residuals.data(), nullptr, static_cast<int>(residuals.size()), 0.0);
}

/// Inliers of σ in d dimensions, outliers uniform.
std::vector<double> Residuals(int inliers, int outliers, double sigma, int dimension, Rng rng) {
  std::vector<double> residuals;
  for (int i = 0; i < inliers; ++i) {
    double square = 0.0;
    for (int k = 0; k < dimension; ++k) square += std::pow(sigma * rng.Normal(), 2);
    residuals.push_back(std::sqrt(square));
  }
  for (int i = 0; i < outliers; ++i) residuals.push_back(rng.Uniform(0.0, 20.0));
  return residuals;
}

double LogLikelihoodRatio(const std::vector<double>& residuals, double extent, int dimension, double share,
                          double sigma) {
  const double ratio = std::pow(extent / (std::sqrt(kTwoPi) * sigma), dimension);
  double sum = 0.0;
  for (const double r : residuals) sum += std::log1p(share * (ratio * std::exp(-0.5 * r * r / (sigma * sigma)) - 1.0));
  return sum;
}

TEST_CASE("The profile of points on the model is that of the smallest sigma and of inliers alone") {
  const MixtureProfile score(0.1, 2.0, 40.0, 1);
  // The share of inliers is at most 1 − 1e-4.
  CHECK(Of(score, std::vector<double>(10, 0.0)) ==
        Approx(10.0 * std::log(1e-4 + (1.0 - 1e-4) * 40.0 / (std::sqrt(kTwoPi) * 0.1))).epsilon(1e-6));
  // All in one distance: σ is that distance.
  CHECK(Of(score, std::vector<double>(10, 0.5)) ==
        Approx(10.0 * (std::log(40.0 / (std::sqrt(kTwoPi) * 0.5)) - 0.5)).epsilon(1e-4));
  // In two dimensions its square is two variances.
  CHECK(Of(MixtureProfile(0.1, 2.0, 40.0, 2), std::vector<double>(10, 0.5)) ==
        Approx(10.0 * (std::log(1600.0 / (kTwoPi * 0.125)) - 1.0)).epsilon(1e-4));
}

TEST_CASE("The profile is the greatest likelihood over sigma and the share of inliers") {
  for (const int dimension : {1, 2})
    for (int trial = 0; trial < 20; ++trial) {
      const double sigma = 0.1 * (1 + trial % 6);
      const std::vector<double> residuals = Residuals(60, 140, sigma, dimension, Rng(trial));
      const double got = Of(MixtureProfile(0.05, 1.5, 40.0, dimension), residuals);
      double best = 0.0;
      for (int i = 1; i < 100; ++i)
        for (int k = 0; k <= 100; ++k)
          best =
              std::max(best, LogLikelihoodRatio(residuals, 40.0, dimension, 0.01 * i, 0.05 * std::pow(30.0, 0.01 * k)));
      CAPTURE(dimension, trial);
      CHECK(got == Approx(best).epsilon(3e-3));
      CHECK(best > 30.0);
    }
}

TEST_CASE("A residual that grows never raises the profile by more than its bins are wide") {
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<double> residuals = Residuals(30, 70, 0.2, 1, Rng(trial));
    const MixtureProfile score(0.05, 1.5, 40.0, 1);
    double last = 1e300, first = 0.0;
    for (int step = 0; step <= 400; ++step) {
      residuals[7] = 0.01 * step;
      const double value = Of(score, residuals);
      REQUIRE(value <= last + 0.02);
      last = std::min(last, value);
      if (step == 0) first = value;
    }
    CHECK(last < first - 2.0);
  }
}

TEST_CASE("The bound of counted residuals is above the profile of all that they may be") {
  Rng rng(9);
  for (int trial = 0; trial < 50; ++trial) {
    const int dimension = 1 + trial % 2;
    const std::vector<double> residuals = Residuals(20, 80, 0.3, dimension, rng.Fork("residuals", trial));
    const MixtureProfile score(0.05, 1.5, 40.0, dimension);
    SquareHistogram histogram;
    for (const double residual : residuals) {
      const double square = std::pow(residual / score.reach(), 2) * (1.0 - 0.2 * rng.Uniform());
      histogram.Add(&square, static_cast<const double*>(nullptr), 1);
    }
    CHECK(score.Bound(histogram) >= Of(score, residuals));
  }
}

}  // namespace
}  // namespace diffsac
