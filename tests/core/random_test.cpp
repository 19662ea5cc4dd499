#include "diffsac/core/random.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "diffsac/core/philox.h"

namespace diffsac {
namespace {

/// Pearson's statistic against equal expected counts.
double ChiSquare(const std::vector<int>& counts) {
  const double expected = std::accumulate(counts.begin(), counts.end(), 0.0) / static_cast<double>(counts.size());
  double sum = 0.0;
  for (const int count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

/// Six standard deviations above the mean of a chi-square with k-1 degrees of freedom.
double ChiSquareBound(std::size_t k) {
  const double freedom = static_cast<double>(k) - 1.0;
  return freedom + 6.0 * std::sqrt(2.0 * freedom);
}

std::vector<std::uint64_t> Draw(Rng rng, int count) {
  std::vector<std::uint64_t> values;
  for (int i = 0; i < count; ++i) values.push_back(rng());
  return values;
}

}  // namespace

TEST_CASE("any normal value can be had by its place") {
  Rng stream(7);
  const Rng at = Rng(7);
  for (int i = 0; i < 9; ++i) CHECK(at.NormalAt(i) == stream.Normal());
  Rng other(7);
  other.Normal();
  CHECK(other.NormalAt(4) == at.NormalAt(4));
}

TEST_CASE("Philox4x32-10 gives the known answers published with Random123") {
  using Block = std::array<std::uint32_t, 4>;
  CHECK(Philox4x32({0, 0, 0, 0}, {0, 0}) == Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  constexpr std::uint32_t kOnes = 0xffffffff;
  CHECK(Philox4x32({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}) ==
        Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  CHECK(Philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
        Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("Rng walks the blocks of its seed in order") {
  Rng rng(0);
  CHECK(rng() == 0xe169c58d6627e8d5u);
  CHECK(rng() == 0x9b00dbd8bc57ac4cu);
  const auto second = Philox4x32({1, 0, 0, 0}, {0, 0});
  CHECK(rng() == (second[0] | (std::uint64_t{second[1]} << 32)));
  CHECK(Draw(Rng(5), 9) == Draw(Rng(5), 9));
  CHECK(Draw(Rng(5), 9) != Draw(Rng(6), 9));
  CHECK(Draw(Rng(Rng(5).Seed()), 9) == Draw(Rng(5), 9));
}

TEST_CASE("Fork depends on key, name and number alone") {
  Rng rng(3);
  const auto before = Draw(rng.Fork("noise", 7), 4);
  for (int i = 0; i < 5; ++i) rng.Normal();
  CHECK(Draw(rng.Fork("noise", 7), 4) == before);
  std::set<std::uint64_t> keys = {rng.Seed()};
  for (const char* name : {"", "a", "b", "noise"}) {
    for (std::uint64_t id = 0; id < 1000; ++id) keys.insert(rng.Fork(name, id).Seed());
  }
  CHECK(keys.size() == 4001);
  CHECK(rng.Fork("a").Fork("b").Seed() != rng.Fork("b").Fork("a").Seed());
  CHECK(rng.Fork("a", 1).Fork("a", 2).Seed() != rng.Fork("a", 2).Fork("a", 1).Seed());
}

TEST_CASE("Forked streams are uncorrelated") {
  const Rng parent(11);
  constexpr int kCount = 40000;
  for (std::uint64_t id = 0; id < 4; ++id) {
    Rng a = parent.Fork("x", id), b = parent.Fork("x", id + 1), c = parent;
    double with_neighbour = 0.0, with_parent = 0.0;
    for (int i = 0; i < kCount; ++i) {
      const double x = a.Normal();
      with_neighbour += x * b.Normal();
      with_parent += x * c.Normal();
    }
    CHECK(std::abs(with_neighbour) / std::sqrt(kCount) < 5.0);
    CHECK(std::abs(with_parent) / std::sqrt(kCount) < 5.0);
  }
}

TEST_CASE("Uniform and Normal have the right moments") {
  Rng rng(1);
  constexpr int kCount = 200000;
  double mean = 0.0, square = 0.0, third = 0.0, fourth = 0.0, uniform = 0.0, uniform_square = 0.0;
  double low = 1.0, high = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double u = rng.Uniform(), z = rng.Normal();
    low = std::min(low, u);
    high = std::max(high, u);
    uniform += u / kCount;
    uniform_square += u * u / kCount;
    mean += z / kCount;
    square += z * z / kCount;
    third += z * z * z / kCount;
    fourth += z * z * z * z / kCount;
  }
  CHECK(low >= 0.0);
  CHECK(high < 1.0);
  CHECK(uniform == Approx(0.5).margin(0.004));
  CHECK(uniform_square == Approx(1.0 / 3.0).margin(0.004));
  CHECK(mean == Approx(0.0).margin(0.012));
  CHECK(square == Approx(1.0).margin(0.02));
  CHECK(third == Approx(0.0).margin(0.05));
  CHECK(fourth == Approx(3.0).margin(0.13));
  const double scaled = rng.Uniform(-2.0, -1.0);
  CHECK(scaled >= -2.0);
  CHECK(scaled < -1.0);
}

TEST_CASE("Below is unbiased, also where the range does not divide 2^64") {
  Rng rng(2);
  std::vector<int> counts(7, 0);
  for (int i = 0; i < 70000; ++i) ++counts[rng.Below(7)];
  CHECK(ChiSquare(counts) < ChiSquareBound(counts.size()));
  // With n = 3/4 of 2^64, a plain remainder would fall into the first third twice as often.
  const std::uint64_t n = 3u * (std::uint64_t{1} << 62);
  std::vector<int> thirds(3, 0);
  for (int i = 0; i < 30000; ++i) {
    const std::uint64_t value = rng.Below(n);
    REQUIRE(value < n);
    ++thirds[value / (n / 3)];
  }
  CHECK(ChiSquare(thirds) < ChiSquareBound(3));
  CHECK(rng.Below(1) == 0);
  CHECK_THROWS_AS(rng.Below(0), std::invalid_argument);
}

TEST_CASE("Distinct draws every ordered set equally often") {
  // (6, 2) and (7, 3) redraw; (4, 3) and (3, 3) shuffle.
  const auto [n, count] = GENERATE(table<int, int>({{6, 2}, {7, 3}, {4, 3}, {3, 3}}));
  Rng rng(4);
  std::map<std::vector<int>, int> seen;
  std::size_t num_sets = 1;
  for (int i = 0; i < count; ++i) num_sets *= static_cast<std::size_t>(n - i);
  std::vector<int> drawn(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < 400 * num_sets; ++i) {
    rng.Distinct(n, count, drawn.data());
    ++seen[drawn];
  }
  REQUIRE(seen.size() == num_sets);
  std::vector<int> counts;
  for (const auto& entry : seen) counts.push_back(entry.second);
  CHECK(ChiSquare(counts) < ChiSquareBound(num_sets));
}

TEST_CASE("Distinct: large draws, empty draws and too many") {
  Rng rng(5);
  for (const int count : {0, 1, 32, 33, 99, 100}) {
    std::vector<int> drawn(static_cast<std::size_t>(count), -1);
    rng.Distinct(100, count, drawn.data());
    const std::set<int> values(drawn.begin(), drawn.end());
    CHECK(values.size() == drawn.size());
    CHECK((values.empty() || (*values.begin() >= 0 && *values.rbegin() < 100)));
  }
  int none = 0;
  CHECK_THROWS_AS(rng.Distinct(1, 2, &none), std::invalid_argument);
}

TEST_CASE("Permutation is a permutation, and uniform") {
  Rng rng(6);
  std::map<std::vector<int>, int> seen;
  for (int i = 0; i < 24 * 400; ++i) ++seen[rng.Permutation(4)];
  REQUIRE(seen.size() == 24);
  std::vector<int> counts;
  for (const auto& entry : seen) counts.push_back(entry.second);
  CHECK(ChiSquare(counts) < ChiSquareBound(24));
  CHECK(rng.Permutation(0).empty());
}

}  // namespace diffsac
