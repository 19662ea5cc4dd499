#include "diffsac/consensus/hypothesis_source.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
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
      std::vector<int> sets;
      const int given = ExhaustiveSource().Draw(num_points, set_size, 1, Rng(1), &sets);
      CHECK(given == (num_points < set_size ? 0 : Combinations(num_points, set_size)));
      CHECK(static_cast<int>(sets.size()) == given * set_size);
      CHECK(SetsAreValid(sets, num_points, set_size));
      CHECK(CountUniqueSets(sets, set_size) == given);
    }
  }
}

TEST_CASE("The uniform source gives valid sets, all equally often") {
  constexpr int kCount = 60000;
  std::vector<int> sets;
  REQUIRE(UniformSource().Draw(6, 2, kCount, Rng(3), &sets) == kCount);
  REQUIRE(SetsAreValid(sets, 6, 2));
  std::vector<int> seen(36, 0);
  for (std::size_t i = 0; i < sets.size(); i += 2) ++seen[sets[i] * 6 + sets[i + 1]];
  for (int a = 0; a < 6; ++a)
    for (int b = a + 1; b < 6; ++b) CHECK(seen[a * 6 + b] == Approx(4000).margin(300));
}

TEST_CASE("The uniform source: appends, repeats with the seed, copes with few points") {
  std::vector<int> first{7, 8}, second, other;
  CHECK(UniformSource().Draw(10, 3, 50, Rng(4), &first) == 50);
  CHECK(first.size() == 152);
  CHECK(first[0] == 7);
  UniformSource().Draw(10, 3, 50, Rng(4), &second);
  CHECK(std::equal(second.begin(), second.end(), first.begin() + 2));
  UniformSource().Draw(10, 3, 50, Rng(5), &other);
  CHECK(other != second);
  std::vector<int> sets;
  CHECK(UniformSource().Draw(2, 3, 50, Rng(4), &sets) == 0);
  CHECK(UniformSource().Draw(5, 3, 0, Rng(4), &sets) == 0);
  CHECK(sets.empty());
  CHECK(UniformSource().Draw(3, 3, 2, Rng(4), &sets) == 2);
  CHECK(sets == std::vector<int>{0, 1, 2, 0, 1, 2});
}

TEST_CASE("Unique sets are counted in any order") {
  CHECK(CountUniqueSets({}, 2) == 0);
  CHECK(CountUniqueSets({0, 1, 0, 2, 1, 2}, 2) == 3);
  CHECK(CountUniqueSets({1, 2, 0, 1, 1, 2, 0, 1}, 2) == 2);
  CHECK(CountUniqueSets({1, 2, 3, 1, 2, 3}, 3) == 1);
}

}  // namespace
}  // namespace diffsac
