#include "diffsac/problem/residual_kernels.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

// Residuals of all sizes, and 0; a number that is no multiple of a vector's length.
std::vector<double> SomeResiduals() {
  std::vector<double> residuals = {0.0, 1e-300, 1e300};
  Rng rng(1);
  for (int i = 0; i < 5000; ++i) residuals.push_back(std::exp(rng.Uniform(-20.0, 14.0)));
  return residuals;
}

}  // namespace

TEST_CASE("agreement and distance are the exponential and the logarithm") {
  const std::vector<double> residuals = SomeResiduals();
  const auto count = static_cast<int>(residuals.size());
  constexpr double kThreshold = 0.3;
  std::vector<float> agreement(count), distance(count);
  WriteAgreement(residuals.data(), kThreshold, count, agreement.data(), distance.data());
  double agreement_error = 0.0, distance_error = 0.0;
  for (int i = 0; i < count; ++i) {
    const double s = residuals[i] / kThreshold, expected = 0.25 * std::log1p(std::min(s, 1e37));
    agreement_error = std::max(agreement_error, std::abs(agreement[i] - std::exp(-2.0 * s * s)));
    if (s < 1e37) distance_error = std::max(distance_error, std::abs(distance[i] - expected) / std::max(1.0, expected));
  }
  CHECK(agreement_error < 3e-7);
  CHECK(distance_error < 3e-7);
  CHECK(agreement[0] == 1.0f);
  CHECK(distance[0] == 0.0f);
  CHECK(std::isfinite(distance[2]));
}

TEST_CASE("a value does not depend on where its point stands") {
  const std::vector<double> residuals = SomeResiduals();
  const auto count = static_cast<int>(residuals.size());
  std::vector<float> agreement(count), distance(count), gains(count);
  WriteAgreement(residuals.data(), 0.3, count, agreement.data(), distance.data());
  WriteGains(residuals.data(), 4.0, count, gains.data());
  for (int i = 0; i < count; i += 7) {
    float one_agreement, one_distance, one_gain;
    WriteAgreement(&residuals[i], 0.3, 1, &one_agreement, &one_distance);
    WriteGains(&residuals[i], 4.0, 1, &one_gain);
    CHECK((one_agreement == agreement[i] && one_distance == distance[i] && one_gain == gains[i]));
  }
}

TEST_CASE("gains and their sum, limits catch what is not a number") {
  const std::vector<double> residuals = SomeResiduals();
  const auto count = static_cast<int>(residuals.size());
  std::vector<float> gains(count);
  WriteGains(residuals.data(), 0.01, count, gains.data());
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const double gain = std::max(0.0, 1.0 - residuals[i] * residuals[i] * 0.01);
    CHECK(gains[i] == Approx(gain).margin(1e-7));
    sum += gain;
  }
  CHECK(SumOfGains(residuals.data(), 0.01, count) == Approx(sum).epsilon(1e-12));
  double limited[] = {1.0, std::numeric_limits<double>::quiet_NaN(), 1e9, std::numeric_limits<double>::infinity()};
  LimitResiduals(5.0, 4, limited);
  CHECK((limited[0] == 1.0 && limited[1] == 5.0 && limited[2] == 5.0 && limited[3] == 5.0));
}

TEST_CASE("hyperplane residuals of lines and planes") {
  const double x[] = {1.0, -2.0, 0.5}, y[] = {0.0, 3.0, 1.5}, z[] = {4.0, -1.0, 2.0};
  const double* columns[] = {x, y, z};
  const double line[] = {0.6, 0.8, -0.5}, plane[] = {0.36, 0.48, 0.8, 1.0};
  double residuals[3];
  HyperplaneResiduals(line, 2, columns, 3, residuals);
  for (int i = 0; i < 3; ++i) CHECK(residuals[i] == Approx(std::abs(0.6 * x[i] + 0.8 * y[i] - 0.5)));
  HyperplaneResiduals(plane, 3, columns, 3, residuals);
  for (int i = 0; i < 3; ++i)
    CHECK(residuals[i] == Approx(std::abs(0.36 * x[i] + 0.48 * y[i] + 0.8 * z[i] + 1.0)).margin(1e-15));
}

}  // namespace diffsac
