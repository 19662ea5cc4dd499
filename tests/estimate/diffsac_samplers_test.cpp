#include "diffsac/estimate/diffsac_samplers.h"
#include "diffsac/core/range.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <numeric>

namespace diffsac {

TEST_CASE("tempered sets are drawn in proportion to p^(1/T)") {
  const std::vector<float> p = {0.8f, 0.4f, 0.2f, 0.0f};
  for (const double temperature : {0.5, 1.0, 2.0}) {
    TemperedSampler source(p, 1, temperature, Rng(3));
    std::vector<int> counts(p.size());
    constexpr int kDraws = 20000;
    int set[1];
    for (int i = 0; i < kDraws; ++i) {
      REQUIRE(source.Next(set));
      ++counts[set[0]];
    }
    double sum = 0.0;
    for (const float value : p) sum += std::pow(value, 1.0 / temperature);
    for (std::size_t i = 0; i < p.size(); ++i)
      CHECK(counts[i] == Approx(kDraws * std::pow(p[i], 1.0 / temperature) / sum).margin(4.0 * std::sqrt(kDraws)));
  }
}

TEST_CASE("tempered draws go through ten temperatures again and again") {
  // Falling probabilities: the colder the rung, the nearer to the first points.
  std::vector<float> p(200);
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = std::exp(-0.05f * static_cast<float>(i));
  TemperedSampler source(p, 3, Range(0.05, 5.0), Rng(4));
  std::vector<double> sums(TemperedSampler::kRungs);
  std::vector<int> set(3);
  for (int i = 0; i < 100 * TemperedSampler::kRungs; ++i) {
    REQUIRE(source.Next(set));
    CHECK(set[0] < set[1]);
    CHECK(set[1] < set[2]);
    sums[i % TemperedSampler::kRungs] += std::accumulate(set.begin(), set.end(), 0.0);
  }
  for (std::size_t r = 1; r < sums.size(); ++r) CHECK(sums[r] > sums[r - 1]);
  CHECK(sums.back() > 5.0 * sums.front());
}

TEST_CASE("tempered sets exist whatever the probabilities and the temperature are") {
  for (const auto& p : {std::vector<float>(5, 0.0f), std::vector<float>{1.0f, 0.0f, 0.0f, 0.0f, 0.0f}})
    for (const double temperature : {1e-4, 1e4}) {
      TemperedSampler source(p, 4, temperature, Rng(1));
      std::vector<int> set(4);
      for (int i = 0; i < 20; ++i) REQUIRE(source.Next(set));
    }
  std::vector<int> set(4);
  CHECK_FALSE(TemperedSampler(std::vector<float>(3, 0.5f), 4, 1.0, Rng(1)).Next(set));
}

TEST_CASE("a ladder of temperatures scales log-probabilities or confidences row by row") {
  std::vector<float> logs = {1.0f, 0.0f, 1.0f, 0.0f}, plain = {0.5f, -0.5f, 0.5f, -0.5f};
  ScaleConfidences(logs, 2, Range(0.5, 2.0), true);
  CHECK(logs[0] == 0.0f);
  CHECK(logs[1] == Approx(2.0 * std::log(0.5)));
  CHECK(logs[3] == Approx(0.5 * std::log(0.5)));
  ScaleConfidences(plain, 2, Range(0.5, 2.0), false);
  CHECK(plain == std::vector<float>{1.0f, -1.0f, 0.25f, -0.25f});
}

}  // namespace diffsac
