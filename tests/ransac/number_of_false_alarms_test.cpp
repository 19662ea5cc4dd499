#include "diffsac/ransac/scores/number_of_false_alarms.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

TEST_CASE("The number of false alarms is the formula's") {
  // (10 − 2) C(10, 4) C(4, 2) .1² = 8 · 210 · 6 · .01
  CHECK(Log10Nfa(10, 4, 2, 0.1) == Approx(std::log10(100.8)));
  CHECK(Log10Nfa(100, 50, 2, 0.01) < -50.0);
  CHECK(Log10Nfa(100, 2, 2, 0.01) == std::numeric_limits<double>::infinity());
  CHECK(Log10Nfa(3, 4, 2, 0.01) == std::numeric_limits<double>::infinity());
  CHECK(Log10Nfa(100, 100, 2, 1.0) > 0.0);
}

TEST_CASE("Best lines through points without structure stay above zero, a true one falls below") {
  constexpr int kPoints = 60;
  constexpr double kThreshold = 0.01;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    double x[kPoints], y[kPoints];
    for (int i = 0; i < kPoints; ++i) {
      x[i] = rng.Uniform();
      y[i] = seed % 2 == 0 || i >= 20 ? rng.Uniform() : 0.3 + 0.2 * x[i];
    }
    int best = 0;
    for (int a = 0; a < kPoints; ++a)
      for (int b = 0; b < a; ++b) {
        const double length = std::hypot(x[a] - x[b], y[a] - y[b]);
        int inliers = 0;
        for (int i = 0; i < kPoints; ++i)
          inliers += std::abs((x[i] - x[a]) * (y[b] - y[a]) - (y[i] - y[a]) * (x[b] - x[a])) <= kThreshold * length;
        best = std::max(best, inliers);
      }
    // The band of a line in the unit square is √2 long at most.
    const double log = Log10Nfa(kPoints, best, 2, 2.0 * kThreshold * std::sqrt(2.0));
    CHECK((log > 0.0) == (seed % 2 == 0));
  }
}

TEST_CASE("The number of chance models is the number of sets times the binomial tail") {
  // C(5, 2) P(X >= 2 of 3) = 10 (3 · .1² · .9 + .1³)
  CHECK(LogChanceModels(5, 4, 2, 0.1) == Approx(std::log10(10.0 * 0.028)));
  CHECK(LogChanceModels(5, 5, 2, 0.1) == Approx(std::log10(10.0 * 0.001)));
  CHECK(LogChanceModels(5, 2, 2, 0.1) == std::numeric_limits<double>::infinity());
  CHECK(LogChanceModels(3, 4, 2, 0.1) == std::numeric_limits<double>::infinity());
  CHECK(LogChanceModels(100, 100, 2, 1.0) == Approx(std::log10(4950.0)));
  CHECK(std::isfinite(LogChanceModels(100000, 90000, 4, 1e-4)));
  for (int k = 4; k < 60; ++k) CHECK(LogChanceModels(60, k, 2, 0.02) > LogChanceModels(60, k + 1, 2, 0.02));
}

}  // namespace
}  // namespace diffsac
