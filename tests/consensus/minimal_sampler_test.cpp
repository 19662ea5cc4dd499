#include "diffsac/consensus/samplers/minimal_sampler.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <set>
#include <vector>

namespace diffsac {
namespace {

bool SetsAreValid(const std::vector<int>& sets, int num_points, int set_size) {
  for (std::size_t start = 0; start < sets.size(); start += set_size)
    for (int i = 0; i < set_size; ++i) {
      const int value = sets[start + i];
      if (value < 0 || value >= num_points || (i > 0 && value <= sets[start + i - 1])) return false;
    }
  return sets.size() % set_size == 0;
}

TEST_CASE("Combinations") {
  CHECK(Combinations(100, 2) == 4950);
  CHECK(Combinations(100, 3) == 161700);
  CHECK(Combinations(5, 0) == 1);
  CHECK(Combinations(5, 5) == 1);
  CHECK(Combinations(2, 3) == 0);
  CHECK(Combinations(3, -1) == 0);
  CHECK(Combinations(1000, 500) == std::numeric_limits<std::int64_t>::max());
}

TEST_CASE("The exhaustive source gives every set once, in order") {
  for (int set_size : {1, 2, 3, 4}) {
    for (int num_points : {0, 1, 2, 3, 4, 9}) {
      ExhaustiveSampler source(num_points, set_size);
      const std::vector<int> sets = DrawSets(source, set_size, 1000);
      const int given = static_cast<int>(sets.size()) / set_size;
      CHECK(given == (num_points < set_size ? 0 : Combinations(num_points, set_size)));
      CHECK(SetsAreValid(sets, num_points, set_size));
      CHECK(CountUniqueSets(sets, set_size) == given);
    }
  }
}

TEST_CASE("The uniform source gives valid sets, all equally often") {
  constexpr int kCount = 60000;
  UniformSampler source(6, 2, Rng(3));
  const std::vector<int> sets = DrawSets(source, 2, kCount);
  REQUIRE(sets.size() == 2 * kCount);
  REQUIRE(SetsAreValid(sets, 6, 2));
  std::vector<int> seen(36, 0);
  for (std::size_t i = 0; i < sets.size(); i += 2) ++seen[sets[i] * 6 + sets[i + 1]];
  for (int a = 0; a < 6; ++a)
    for (int b = a + 1; b < 6; ++b) CHECK(seen[a * 6 + b] == Approx(4000).margin(300));
}

TEST_CASE("The uniform source repeats with the seed and copes with few points") {
  const auto drawn = [](int num_points, int set_size, int count, int seed) {
    UniformSampler source(num_points, set_size, Rng(seed));
    return DrawSets(source, set_size, count);
  };
  CHECK(drawn(10, 3, 50, 4).size() == 150);
  CHECK(drawn(10, 3, 50, 4) == drawn(10, 3, 50, 4));
  CHECK(drawn(10, 3, 50, 4) != drawn(10, 3, 50, 5));
  CHECK(drawn(2, 3, 50, 4).empty());
  CHECK(drawn(5, 3, 0, 4).empty());
  CHECK(drawn(3, 3, 2, 4) == std::vector<int>{0, 1, 2, 0, 1, 2});
}

TEST_CASE("All sets where the budget holds them, else uniform ones") {
  CHECK(DrawAllOrSome(4, 2, 6, Rng(1)) == std::vector<int>{0, 1, 0, 2, 0, 3, 1, 2, 1, 3, 2, 3});
  UniformSampler uniform(4, 2, Rng(1));
  CHECK(DrawAllOrSome(4, 2, 5, Rng(1)) == DrawSets(uniform, 2, 5));
  CHECK(DrawAllOrSome(1, 2, 5, Rng(1)).empty());
}

TEST_CASE("A sequence gives each source its share, and goes on where one runs out") {
  const std::vector<int> few{0, 1, 0, 2}, more{3, 4, 5, 6, 7, 8};
  SequenceSampler source;
  source.Add(std::make_unique<PrecomputedSampler>(more), 2);
  source.Add(std::make_unique<PrecomputedSampler>(few), 5);
  source.Add(std::make_unique<PrecomputedSampler>(more), 0);
  source.Add(std::make_unique<ExhaustiveSampler>(3, 2));
  CHECK(DrawSets(source, 2, 100) == std::vector<int>{3, 4, 5, 6, 0, 1, 0, 2, 0, 1, 0, 2, 1, 2});
  SequenceSampler nothing;
  CHECK(DrawSets(nothing, 2, 3).empty());
}

TEST_CASE("Unique sets are counted in any order") {
  CHECK(CountUniqueSets({}, 2) == 0);
  CHECK(CountUniqueSets({0, 1, 0, 2, 1, 2}, 2) == 3);
  CHECK(CountUniqueSets({1, 2, 0, 1, 1, 2, 0, 1}, 2) == 2);
  CHECK(CountUniqueSets({1, 2, 3, 1, 2, 3}, 3) == 1);
}

}  // namespace
}  // namespace diffsac
