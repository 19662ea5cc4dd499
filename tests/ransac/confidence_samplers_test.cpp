#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/ransac/samplers/confidence_sampler.h"
#include "diffsac/ransac/samplers/prosac_sampler.h"

namespace diffsac {
namespace {

using Sets = std::vector<int>;

Sets Draw(const std::vector<float>& confidences, int num_points, int set_size, int count, Selection selection,
          bool unique, double temperature = 1.0, std::uint64_t seed = 1) {
  ConfidenceSampler source(confidences, num_points, set_size, selection, unique, temperature, Rng(seed));
  return DrawSets(source, set_size, count);
}

TEST_CASE("Maximum selection takes the most confident points, the lower index where they tie") {
  const std::vector<float> confidences{0.1f, 0.9f, 0.5f, 0.9f,   //
                                       0.3f, 0.3f, 0.3f, 0.3f};  //
  CHECK(Draw(confidences, 4, 2, 2, Selection::kMaximum, false) == Sets{1, 3, 0, 1});
}

TEST_CASE("A repeated set becomes the next one: the worst member replaced in order of confidence") {
  std::vector<float> confidences;
  for (int copy = 0; copy < 6; ++copy) confidences.insert(confidences.end(), {0.1f, 0.9f, 0.5f, 0.8f});
  // The order is 1, 3, 2, 0: three sets hold point 1; then the sets of the rest by rising ranks.
  CHECK(Draw(confidences, 4, 2, 6, Selection::kMaximum, true) == Sets{1, 3, 1, 2, 0, 1, 2, 3, 0, 3, 0, 2});
  CHECK(Draw(confidences, 4, 2, 6, Selection::kMaximum, false) == Sets{1, 3, 1, 3, 1, 3, 1, 3, 1, 3, 1, 3});
}

TEST_CASE("Unique sets run out without repeating") {
  std::vector<float> confidences(10 * 4, 1.0f);
  for (Selection selection : {Selection::kMaximum, Selection::kProbabilistic}) {
    const Sets sets = Draw(confidences, 4, 2, 10, selection, true);
    CHECK(sets.size() == 12);
    CHECK(CountUniqueSets(sets, 2) == 6);
  }
}

TEST_CASE("20 equal copies of 100 points give 20 unique sets") {
  Rng rng(2);
  std::vector<float> one(100), confidences;
  for (float& value : one) value = static_cast<float>(rng.Normal());
  for (int copy = 0; copy < 20; ++copy) confidences.insert(confidences.end(), one.begin(), one.end());
  for (int set_size : {2, 3})
    for (Selection selection : {Selection::kMaximum, Selection::kProbabilistic}) {
      const Sets sets = Draw(confidences, 100, set_size, 20, selection, true);
      CHECK(CountUniqueSets(sets, set_size) == 20);
      for (std::size_t i = 0; i < sets.size(); i += set_size)
        CHECK(std::is_sorted(sets.begin() + i, sets.begin() + i + set_size));
    }
}

TEST_CASE("Non-finite confidences rank last") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> confidences{nan, infinity, -5.0f, -9.0f, -infinity};
  CHECK(Draw(confidences, 5, 2, 1, Selection::kMaximum, true) == Sets{2, 3});
  CHECK(Draw(confidences, 5, 2, 1, Selection::kProbabilistic, true) == Sets{2, 3});
  CHECK(Draw(std::vector<float>(5, nan), 5, 2, 1, Selection::kMaximum, true) == Sets{0, 1});
}

TEST_CASE("Probabilistic selection draws without replacement by the softmax of the confidences") {
  const std::vector<double> share{0.5, 0.3, 0.15, 0.05};
  constexpr double kTemperature = 0.5;
  std::vector<float> confidences;
  constexpr int kDraws = 40000;
  for (double value : share) confidences.push_back(static_cast<float>(kTemperature * std::log(value)));
  const Sets sets = Draw(confidences, 4, 2, kDraws, Selection::kProbabilistic, false, kTemperature);
  REQUIRE(sets.size() == 2 * kDraws);
  std::vector<double> seen(16, 0.0);
  for (std::size_t i = 0; i < sets.size(); i += 2) {
    REQUIRE(sets[i] < sets[i + 1]);
    seen[sets[i] * 4 + sets[i + 1]] += 1.0 / kDraws;
  }
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b) {
      const double expected = share[a] * share[b] * (1.0 / (1.0 - share[a]) + 1.0 / (1.0 - share[b]));
      CHECK(seen[a * 4 + b] == Approx(expected).margin(0.01));
    }
}

TEST_CASE("A draw depends on its seed and its place alone") {
  Rng rng(3);
  std::vector<float> confidences(20 * 30);
  for (float& value : confidences) value = static_cast<float>(rng.Normal());
  const Sets all = Draw(confidences, 30, 3, 20, Selection::kProbabilistic, false);
  CHECK(all == Draw(confidences, 30, 3, 20, Selection::kProbabilistic, false));
  const Sets some = Draw(confidences, 30, 3, 5, Selection::kProbabilistic, false);
  CHECK(std::equal(some.begin(), some.end(), all.begin()));
  CHECK(all != Draw(confidences, 30, 3, 20, Selection::kProbabilistic, false, 1.0, 2));
}

TEST_CASE("Too few points or no confidences give nothing") {
  CHECK(Draw({1.0f}, 1, 2, 5, Selection::kMaximum, true).empty());
  CHECK(Draw({}, 0, 2, 5, Selection::kMaximum, true).empty());
  CHECK(Draw({1.0f, 2.0f}, 3, 2, 5, Selection::kMaximum, true).empty());
  CHECK(Draw({1.0f, 2.0f}, 2, 2, 0, Selection::kMaximum, true).empty());
}

/// T'_n by the recurrences of the paper, in long double.
std::vector<std::int64_t> LimitsByRecurrence(int m, int num_points, long double samples) {
  long double average = samples;
  for (int i = 0; i < m; ++i) average *= static_cast<long double>(m - i) / (num_points - i);
  std::vector<std::int64_t> limits{1};
  for (int n = m; n < num_points; ++n) {
    const long double next = average * (n + 1) / (n + 1 - m);
    limits.push_back(limits.back() + static_cast<std::int64_t>(std::ceil((next - average) * (1.0L - 1e-9L))));
    average = next;
  }
  return limits;
}

TEST_CASE("A small growth function by hand") {
  // All 6 pairs of 4 points: 1 within the best 2, 3 within the best 3.
  GrowthFunction growth(2, 4, 200000);
  const int expected[] = {2, 3, 3, 4, 4, 4, 5, 5};
  for (int t = 1; t <= 8; ++t) CHECK(growth.SubsetSize(t) == expected[t - 1]);
  // Half as many sets: T = .5, 1.5, 3.
  GrowthFunction shorter(2, 4, 3);
  const int sooner[] = {2, 3, 4, 4, 5};
  for (int t = 1; t <= 5; ++t) CHECK(shorter.SubsetSize(t) == sooner[t - 1]);
  CHECK(GrowthFunction(3, 3, 10).SubsetSize(1) == 3);
  CHECK(GrowthFunction(3, 3, 10).SubsetSize(2) == 4);
}

TEST_CASE("The growth function follows the paper's recurrences") {
  for (int m : {2, 4, 5, 7, 8})
    for (int num_points : {m, m + 1, 50, 1000, 5000}) {
      const long double samples = std::min<long double>(200000, Combinations(num_points, m));
      const auto limits = LimitsByRecurrence(m, num_points, samples);
      GrowthFunction growth(m, num_points, 200000);
      int mistakes = 0;
      for (int n = m; n <= num_points; ++n) {
        const std::int64_t limit = limits[n - m];
        mistakes += growth.SubsetSize(limit) > n;
        mistakes += growth.SubsetSize(limit + 1) <= n;
      }
      CAPTURE(m, num_points);
      CHECK(mistakes == 0);
      CHECK(growth.SubsetSize(1) == m);
    }
}

TEST_CASE("Sorting as far as it is asked for is sorting all") {
  Rng rng(3);
  for (const int count : {1, 5, 127, 128, 129, 1000}) {
    std::vector<double> quality(count);
    for (double& value : quality) value = 0.1 * static_cast<double>(rng.Below(40));
    std::vector<int> expected(count);
    std::iota(expected.begin(), expected.end(), 0);
    std::stable_sort(expected.begin(), expected.end(), [&](int a, int b) { return quality[a] < quality[b]; });
    QualityOrder upwards(quality), anyhow(quality);
    int mistakes = 0;
    for (int place = 0; place < count; ++place) mistakes += upwards[place] != expected[place];
    for (int i = 0; i < count; ++i) {
      const int place = static_cast<int>(rng.Below(count));
      mistakes += anyhow[place] != expected[place];
    }
    CHECK(mistakes == 0);
    CHECK(OrderByQuality(quality) == expected);
  }
}

TEST_CASE("Order by quality: rising, ties by index, non-finite last") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  CHECK(OrderByQuality(std::vector<double>{0.5, nan, 0.1, -inf, 0.5, -2.0}) == std::vector<int>{5, 2, 0, 4, 1, 3});
  CHECK(OrderByQuality({}).empty());
}

TEST_CASE("Each draw holds the newest point of its subset and better ones") {
  constexpr int kPoints = 40, kSize = 3, kDraws = 20000;
  std::vector<double> quality(kPoints);
  for (int i = 0; i < kPoints; ++i) quality[i] = kPoints - i;  // The last point is the best.
  ProsacSampler source(quality, kSize, Rng(1));
  GrowthFunction growth(kSize, kPoints, 200000);
  const std::vector<int> sets = DrawSets(source, kSize, kDraws);
  REQUIRE(sets.size() == kDraws * kSize);
  CHECK(std::vector<int>(sets.begin(), sets.begin() + 3) == std::vector<int>{37, 38, 39});
  int wrong = 0, repeated = 0, from_worst = 0, uniform = 0;
  for (int t = 1; t <= kDraws; ++t) {
    const int* set = sets.data() + (t - 1) * kSize;
    const int subset = growth.SubsetSize(t);
    repeated += std::adjacent_find(set, set + kSize) != set + kSize;
    if (subset <= kPoints) {
      wrong += set[0] != kPoints - subset;
    } else {
      ++uniform;
      from_worst += set[0] == 0;
    }
  }
  CHECK(wrong == 0);
  // A fault put in by hand, the others drawn from all of the subset, was seen by no test.
  CHECK(repeated == 0);
  CHECK(uniform > kDraws / 2);
  CHECK(static_cast<double>(from_worst) / uniform == Approx(3.0 / kPoints).margin(0.01));
}

TEST_CASE("PROSAC finds good sets sooner where the order is good") {
  // The best 20 of 200 are inliers but for every fourth; sets of four.
  std::vector<double> quality(200);
  std::iota(quality.begin(), quality.end(), 0.0);
  const auto good_sets = [&](MinimalSampler&& source, int count) {
    const std::vector<int> sets = DrawSets(source, 4, count);
    int good = 0;
    for (std::size_t i = 0; i < sets.size(); i += 4)
      good += std::all_of(sets.begin() + i, sets.begin() + i + 4, [](int p) { return p < 20 && p % 4 != 3; });
    return good;
  };
  CHECK(good_sets(ProsacSampler(quality, 4, Rng(2)), 20) >= 3);
  CHECK(good_sets(UniformSampler(200, 4, Rng(2)), 1000) <= 1);
}

TEST_CASE("PROSAC gives no set of another size, and none where there are too few points") {
  const std::vector<double> quality{1.0, 2.0, 3.0};
  const auto drawn = [&](std::span<const double> q, int made_for, int size) {
    ProsacSampler source(q, made_for, Rng(1));
    return DrawSets(source, size, 5).size();
  };
  CHECK(drawn(quality, 2, 2) == 10);
  CHECK(drawn(quality, 2, 3) == 0);
  CHECK(drawn(quality, 4, 4) == 0);
  CHECK(drawn(quality, 0, 0) == 0);
  CHECK(drawn({}, 2, 2) == 0);
}

}  // namespace

}  // namespace diffsac
