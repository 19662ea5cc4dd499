#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "diffsac/consensus/samplers/confidence_sampler.h"

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

}  // namespace
}  // namespace diffsac
