#include "diffsac/ransac/scores/noise_scales.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

constexpr int kFree = 7;

/// Of a model of kFree points, its inliers and uniform outliers up to `extent`.
std::vector<double> MakeResiduals(int inliers, int outliers, double sigma, double extent, Rng& rng) {
  std::vector<double> residuals(kFree, 0.0);
  for (int i = kFree; i < inliers; ++i) residuals.push_back(std::abs(sigma * rng.Normal()));
  for (int i = 0; i < outliers; ++i) residuals.push_back(rng.Uniform(0.0, extent));
  return residuals;
}

double Estimated(const std::vector<double>& residuals, const ThresholdRange& range) {
  return NoiseEstimator(range, kFree).Threshold(residuals.data(), static_cast<int>(residuals.size()));
}

TEST_CASE("The noise is found again, whatever it is and whatever outliers there are, at any unit") {
  for (const double unit : {1e-6, 1.0, 1e6})
    for (const double sigma : {0.2, 0.4, 0.8})
      for (const int outliers : {0, 200, 800}) {
        CAPTURE(unit, sigma, outliers);
        double sum = 0.0;
        for (int trial = 0; trial < 10; ++trial) {
          Rng rng(trial);
          const auto residuals = MakeResiduals(200, outliers, unit * sigma, unit * 500.0, rng);
          const double threshold = Estimated(residuals, {0.25 * unit, 4.0 * unit, 500.0 * unit});
          CHECK(threshold >= 0.25 * unit);
          CHECK(threshold <= 4.0 * unit);
          sum += threshold / (kSigmasOfInlier * sigma * unit);
        }
        CHECK(sum / 10.0 == Approx(1.0).margin(0.15));
      }
}

TEST_CASE("The noise of many points is found between the steps of thresholds, from one end of the range to the other") {
  const ThresholdRange range{0.25, 4.0, 500.0};
  Rng rng(2);
  for (double threshold = 0.3; threshold < 3.2; threshold *= 1.05) {
    const auto residuals = MakeResiduals(20000, 5000, threshold / kSigmasOfInlier, 500.0, rng);
    CAPTURE(threshold);
    // Bins of a quarter of an octave make it a little large.
    const double ratio = Estimated(residuals, range) / threshold;
    CHECK((ratio > 0.99 && ratio < 1.07));
  }
}

TEST_CASE("Noise beyond the range gives its end") {
  Rng rng(1);
  CHECK(Estimated(MakeResiduals(200, 200, 0.01, 500.0, rng), {0.5, 4.0, 500.0}) == Approx(0.5));
  CHECK(Estimated(MakeResiduals(200, 200, 5.0, 500.0, rng), {0.5, 4.0, 500.0}) == Approx(4.0));
  CHECK(Estimated(MakeResiduals(200, 200, 0.1, 500.0, rng), {4.0, 4.0, 500.0}) == 4.0);
}

TEST_CASE("A model that no point but its own supports has no noise, and residuals that are no numbers no say") {
  const ThresholdRange range{0.5, 4.0, 500.0};
  CHECK(Estimated(std::vector<double>(kFree, 0.0), range) == 4.0);
  CHECK(Estimated({}, range) == 4.0);
  Rng rng(3);
  auto residuals = MakeResiduals(200, 100, 0.4, 500.0, rng);
  auto with_wild = residuals;
  residuals.insert(residuals.end(), 3, 1e3);
  for (const double wild : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300})
    with_wild.push_back(wild);
  CHECK(Estimated(with_wild, range) == Estimated(residuals, range));
}

}  // namespace
}  // namespace diffsac
