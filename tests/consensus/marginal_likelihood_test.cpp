#include "diffsac/consensus/scores/marginal_likelihood.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/consensus/scores/score.h"
#include "diffsac/core/random.h"

namespace diffsac {
namespace {

constexpr double kPi = 3.14159265358979323846;

double Of(const MarginalLikelihood& score, const std::vector<double>& residuals) {
  return score.OfAll(residuals.data(), nullptr, static_cast<int>(residuals.size()), 0.0);
}

/// The paper's formula for these inliers, with lengths in units of a, less its value for none.
double Formula(const std::vector<double>& inliers, double a, int dimension, int free) {
  double rss = 0.0;
  for (const double r : inliers) rss += r * r / (a * a);
  const double half_dof = 0.5 * (static_cast<double>(inliers.size()) - free) * dimension;
  return std::lgamma(half_dof) - half_dof * std::log(kPi * rss) + inliers.size() * dimension * std::log(2.0);
}

/// Residuals of `inliers` points near a model and of others anywhere.
std::vector<double> Residuals(int inliers, int outliers, double sigma, Rng rng) {
  std::vector<double> residuals;
  for (int i = 0; i < inliers; ++i) residuals.push_back(std::abs(sigma * rng.Normal()));
  for (int i = 0; i < outliers; ++i) residuals.push_back(rng.Uniform(0.0, 20.0));
  return residuals;
}

TEST_CASE("The marginal likelihood of few points is its closed form") {
  // γ = 1: ν = 1, Γ(1/2) = √π, −log(π (9 + 16)/100)/2 + 2 log 2.
  CHECK(Of(MarginalLikelihood(10.0, 1, 1, 0.0, 1.0), {3.0, 4.0}) == Approx(std::log(8.0)).epsilon(1e-9));
  // γ = 0: the nearer point alone has more, Γ(1/2) = √π, −log(π 9/100)/2 + log 2.
  CHECK(Of(MarginalLikelihood(10.0, 1, 0, 0.0, 1.0), {3.0, 4.0}) == Approx(std::log(2.0 / 0.3)).epsilon(1e-9));
  // Two dimensions, γ = 1: ν = 2, Γ(1) = 1, −log(π · 25/100) + 4 log 2.
  const MarginalLikelihood planar(10.0, 2, 1, 0.0, 1.0);
  CHECK(Of(planar, {3.0, 4.0}) == Approx(std::log(16.0 / (0.25 * kPi))).epsilon(1e-9));
  // Without points the model leaves free there is nothing to say.
  CHECK(Of(planar, {3.0}) == 0.0);
  CHECK(Of(MarginalLikelihood(10.0, 1, 2, 0.0, 1.0), {3.0, 4.0}) == 0.0);
  // Under the prior of one inlier with σ₀ = 5 the density of one residual of 5 is Cauchy's, 1/(5π(1 + 1)); an outlier's
  // is 1/200.
  CHECK(Of(MarginalLikelihood(100.0, 1, 0, 1.0, 5.0), {5.0}) == Approx(std::log(20.0 / kPi)).epsilon(1e-9));
  CHECK(Of(MarginalLikelihood(100.0, 1, 0, 1.0, 1.0), {1.0}) == Approx(std::log(100.0 / kPi)).epsilon(1e-9));
}

TEST_CASE("The marginal likelihood is the formula's greatest value over all numbers of inliers") {
  for (const int dimension : {1, 2})
    for (const int free : {0, 2, 7})
      for (int trial = 0; trial < 30; ++trial) {
        const Rng rng = Rng(trial).Fork("residuals");
        std::vector<double> residuals = Residuals(40, 160, 0.05 * (1 + trial % 7), rng);
        const double got = Of(MarginalLikelihood(12.0, dimension, free, 0.0, 1.0), residuals);
        std::sort(residuals.begin(), residuals.end());
        double best = 0.0;
        for (std::size_t n = free + 1; n <= residuals.size() && residuals[n - 1] < 12.0; ++n)
          best = std::max(best, Formula({residuals.begin(), residuals.begin() + n}, 12.0, dimension, free));
        CAPTURE(dimension, free, trial);
        CHECK(got == Approx(best).epsilon(1e-8));
        CHECK(got > 0.0);
      }
}

TEST_CASE("The smallest residuals are the best inliers of all subsets") {
  for (int trial = 0; trial < 10; ++trial) {
    const std::vector<double> residuals = Residuals(5, 5, 0.3, Rng(trial));
    double best = 0.0;
    for (unsigned subset = 1; subset < 1024; ++subset) {
      std::vector<double> inliers;
      for (int i = 0; i < 10; ++i)
        if ((subset >> i & 1u) != 0) inliers.push_back(residuals[i]);
      const bool inside = *std::max_element(inliers.begin(), inliers.end()) < 12.0;
      if (inside && inliers.size() > 1) best = std::max(best, Formula(inliers, 12.0, 1, 1));
    }
    CHECK(Of(MarginalLikelihood(12.0, 1, 1, 0.0, 1.0), residuals) == Approx(best).epsilon(1e-8));
  }
}

/// log of ∫ Π N(r; 0, σ²) InvGamma(σ²; n₀/2, n₀σ₀²/2) dσ² · (2a)^n, in many steps of log σ.
double Integral(const std::vector<double>& inliers, double a, double prior, double sigma) {
  constexpr int kSteps = 20000;
  const double shape = 0.5 * prior, scale = 0.5 * prior * sigma * sigma;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double log_variance = -30.0 + 60.0 * (i + 0.5) / kSteps, variance = std::exp(log_variance);
    double log = shape * std::log(scale) - std::lgamma(shape) - (shape + 1.0) * log_variance - scale / variance;
    for (const double r : inliers)
      log += std::log(2.0 * a) - 0.5 * std::log(2.0 * kPi * variance) - 0.5 * r * r / variance;
    sum += std::exp(log + log_variance);
  }
  return std::log(sum * 60.0 / kSteps);
}

TEST_CASE("Under a prior the marginal likelihood is the integral over sigma") {
  const std::vector<double> residuals = {0.1, 0.3, 0.2, 0.05};
  for (const double prior : {0.5, 1.0, 4.0, 20.0})
    for (const double sigma : {0.1, 0.2, 1.0}) {
      CAPTURE(prior, sigma);
      // All four are inliers: with these few, near ones the sum only rises.
      CHECK(Of(MarginalLikelihood(50.0, 1, 0, prior, sigma), residuals) ==
            Approx(Integral(residuals, 50.0, prior, sigma)).epsilon(1e-6));
    }
}

TEST_CASE("A residual that grows never raises the marginal likelihood") {
  for (const double prior : {0.0, 5.0})
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<double> residuals = Residuals(15, 15, 0.2, Rng(trial));
      std::vector<double> weights(residuals.size(), 1.0);
      if (trial % 2 == 1)
        for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = Rng(trial).Fork("weight", i).Uniform();
      const MarginalLikelihood score(12.0, 1, 2, prior, 0.2);
      double last = 1e300;
      for (int step = 0; step <= 400; ++step) {
        residuals[7] = 0.04 * step;
        const double value = score.OfAll(residuals.data(), weights.data(), 30, 0.0);
        REQUIRE(value <= last + 1e-9);
        last = value;
      }
    }
}

TEST_CASE("The bound of counted residuals is above the score of all that they may be") {
  Rng rng(9);
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<double> residuals = Residuals(20, 80, 0.3, rng.Fork("residuals", trial));
    const MarginalLikelihood score(12.0, 1, 5, trial % 2 == 0 ? 0.0 : 3.0, 0.3);
    SquareHistogram histogram;
    for (const double residual : residuals) {
      const double square = residual * residual / 144.0, least = square * (1.0 - 0.2 * rng.Uniform());
      histogram.Add(&least, static_cast<const double*>(nullptr), 1);
    }
    const double value = Of(score, residuals);
    CHECK(score.BoundOfAll(histogram) >= value);
    CHECK(score.BoundOfAll(histogram) < 2.0 * value);
  }
}

TEST_CASE("A square is in the bin whose edges it is between, four an octave") {
  Rng rng(1);
  for (int i = 0; i < 10000; ++i) {
    const double square = std::exp(-20.0 * rng.Uniform());
    const int bin = SquareHistogram::BinOf(square);
    REQUIRE(bin >= 0);
    REQUIRE(bin < SquareHistogram::kBins);
    REQUIRE(SquareHistogram::Least(bin) <= square);
    if (bin + 1 < SquareHistogram::kBins) REQUIRE(square < SquareHistogram::Least(bin + 1));
  }
  constexpr int kLast = SquareHistogram::kBins - 1;
  CHECK(SquareHistogram::BinOf(std::nextafter(1.0, 0.0)) == kLast);
  CHECK(SquareHistogram::Least(kLast) == 0.875);
  CHECK(SquareHistogram::Least(kLast - 3) == 0.5);
  CHECK(SquareHistogram::Least(0) == 0.0);
  for (const double least : {0.0, -0.0, -1e-9, 1e-300}) CHECK(SquareHistogram::BinOf(least) == 0);
}

TEST_CASE("Weights and squares add up, and what is far or no number counts in the total alone") {
  SquareHistogram histogram;
  const std::vector<double> squares = {0.6, 0.55, 1.0, 2.0, std::numeric_limits<double>::quiet_NaN(), 1e-20};
  const std::vector<double> weights = {1.0, 0.5, 0.25, 1.0, 1.0, 0.125};
  histogram.Add(squares.data(), weights.data(), 6);
  const SquareHistogram::Bin& bin = histogram[SquareHistogram::BinOf(0.6)];
  CHECK(bin.weight == 1.5);
  CHECK(bin.squares == Approx(0.6 + 0.5 * 0.55));
  CHECK(histogram[0].weight == 0.125);
  CHECK(histogram.total() == 3.875);
  double sum = 0.0;
  for (int b = 0; b < SquareHistogram::kBins; ++b) sum += histogram[b].weight;
  CHECK(sum == 1.625);
}

}  // namespace
}  // namespace diffsac
