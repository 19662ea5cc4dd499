#include "lab/eval/bootstrap.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <stdexcept>

namespace diffsac {
namespace {

SceneValues NormalValues(double mean, int count, std::uint64_t seed) {
  Rng rng(seed);
  SceneValues values(1);
  for (int i = 0; i < count; ++i) values[0].push_back(mean + rng.Normal());
  return values;
}

TEST_CASE("the bootstrap repeats with its seed and differs with another") {
  const SceneValues values = NormalValues(1.0, 100, 1);
  const auto a = BootstrapMean(values, Rng(7)), b = BootstrapMean(values, Rng(7)), c = BootstrapMean(values, Rng(8));
  CHECK(a.low == b.low);
  CHECK(a.high == b.high);
  CHECK(a.low != c.low);
  CHECK(a.mean == c.mean);
}

TEST_CASE("the interval has the width that theory says") {
  const SceneValues values = NormalValues(0.0, 400, 2);
  const auto interval = BootstrapMean(values, Rng(1), 4000);
  CHECK(interval.low < interval.mean);
  CHECK(interval.mean < interval.high);
  CHECK(interval.high - interval.low == Approx(2 * 1.96 / 20.0).epsilon(0.15));
}

TEST_CASE("of one round there is one value, of two the interval lies between them") {
  const SceneValues values = NormalValues(0.0, 50, 2);
  const auto one = BootstrapMean(values, Rng(1), 1), two = BootstrapMean(values, Rng(1), 2, 0.5);
  CHECK(one.low == one.high);
  // The same first round; quarters of the way from one value to the other.
  const double other = two.low + two.high - one.low;
  CHECK(two.high - two.low == Approx(0.5 * std::abs(other - one.low)));
}

TEST_CASE("scenes weigh the same, whatever their size") {
  const SceneValues values = {{1.0, 1.0, 1.0, 1.0}, {0.0}};
  const auto interval = BootstrapMean(values, Rng(1));
  CHECK(interval.mean == 0.5);
  CHECK(interval.low == 0.5);
  CHECK(interval.high == 0.5);
}

TEST_CASE("a paired difference is far tighter than the values' spread") {
  SceneValues a = NormalValues(0.0, 200, 3), b = a;
  Rng rng(4);
  for (double& value : a[0]) value += 0.1 + 0.01 * rng.Normal();
  const auto difference = BootstrapDifference(a, b, Rng(5));
  CHECK(difference.mean == Approx(0.1).margin(0.005));
  CHECK(difference.low > 0.09);
  CHECK(difference.high < 0.11);
}

TEST_CASE("no values give NaN, different shapes throw") {
  CHECK(std::isnan(BootstrapMean({}, Rng(1)).mean));
  CHECK(std::isnan(BootstrapMean({{}}, Rng(1)).low));
  CHECK_THROWS_AS(BootstrapDifference({{1.0}}, {{1.0, 2.0}}, Rng(1)), std::invalid_argument);
  CHECK_THROWS_AS(BootstrapDifference({{1.0}}, {}, Rng(1)), std::invalid_argument);
}

}  // namespace
}  // namespace diffsac
