#include "diffsac/problem/nearest_eight.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

// By comparing everything with everything.
EightNearest Expected(const PlanePoints& points, double x, double y, int own) {
  std::vector<std::pair<double, int>> ranked;
  for (int j = 0; j < static_cast<int>(points.size()); ++j) {
    const double dx = points.x[j] - x, dy = points.y[j] - y;
    if (j != own) ranked.emplace_back(dx * dx + dy * dy, j);
  }
  std::partial_sort(ranked.begin(), ranked.begin() + kEight, ranked.end());
  EightNearest nearest;
  for (int k = 0; k < kEight; ++k) nearest[k] = ranked[k].second;
  return nearest;
}

// The points themselves, and as many other places.
void CheckAll(const PlanePoints& points, const PlanePoints& others) {
  PlanePoints places = points;
  places.x.insert(places.x.end(), others.x.begin(), others.x.end());
  places.y.insert(places.y.end(), others.y.begin(), others.y.end());
  std::vector<std::int32_t> own(places.size(), -1);
  std::iota(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(points.size()), 0);
  const auto nearest = NearestEight(points, places, own);
  REQUIRE(nearest.size() == places.size());
  int wrong = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    wrong += nearest[i] == Expected(points, places.x[i], places.y[i], own[i]) ? 0 : 1;
  CHECK(wrong == 0);
}

template <class Place>
PlanePoints Make(int count, const Place& place) {
  PlanePoints points(count);
  for (int i = 0; i < count; ++i) std::tie(points.x[i], points.y[i]) = place(i);
  return points;
}

using Pair = std::pair<double, double>;

}  // namespace

TEST_CASE("nearest eight: the same as comparing all, however the points lie") {
  Rng rng(4);
  const auto anywhere = [&](int) { return Pair(rng.Uniform(-1.0, 1.0), rng.Uniform(-0.7, 0.7)); };
  const auto clusters = [&](int i) {
    return Pair(i % 3 + 1e-3 * rng.Normal(), i % 5 == 0 ? rng.Uniform(-1.0, 1.0) : 1e-5 * rng.Normal());
  };
  const auto line = [&](int) { return Pair(rng.Uniform(-3.0, 3.0), 0.25); };
  const auto outlier = [&](int i) { return i == 7 ? Pair(1e3, -1e4) : Pair(rng.Uniform(), rng.Uniform()); };
  for (const int count : {9, 10, 16, 17, 63, 64, 65, 500, 1501}) {
    CheckAll(Make(count, anywhere), Make(count, anywhere));
    CheckAll(Make(count, clusters), Make(count, anywhere));
    CheckAll(Make(count, line), Make(count, clusters));
    CheckAll(Make(count, outlier), Make(count, outlier));
  }
}

TEST_CASE("nearest eight: of equally near points the lower numbers") {
  Rng rng(5);
  const auto lattice = [&](int) {
    return Pair(static_cast<double>(rng.Below(12)) / 64.0, static_cast<double>(rng.Below(12)) / 64.0);
  };
  const auto one_place = [](int) { return Pair(0.5, -0.25); };
  const auto two_places = [](int i) { return Pair(i % 2, 0.0); };
  for (const int count : {9, 40, 700}) {
    CheckAll(Make(count, lattice), Make(count, lattice));
    CheckAll(Make(count, one_place), Make(count, lattice));
    CheckAll(Make(count, two_places), Make(count, one_place));
  }
}

TEST_CASE("nearest eight: huge, tiny and not finite coordinates") {
  Rng rng(6);
  for (const double unit : {1e-300, 1e-20, 1e20, 1e300}) {
    const auto anywhere = [&](int) { return Pair(rng.Uniform(), rng.Uniform()); };
    const PlanePoints points = Make(100, anywhere);
    PlanePoints scaled = points;
    for (int i = 0; i < 100; ++i) scaled.x[i] *= unit, scaled.y[i] *= unit;
    const std::vector<std::int32_t> own(100, -1);
    const auto nearest = NearestEight(points, points, own), after = NearestEight(scaled, scaled, own);
    for (int i = 0; i < 100; ++i) CHECK(nearest[i][0] == after[i][0]);
  }
  PlanePoints broken(20);
  broken.x[3] = std::numeric_limits<double>::quiet_NaN();
  broken.y[4] = std::numeric_limits<double>::infinity();
  const auto nearest = NearestEight(broken, broken, std::vector<std::int32_t>(20, -1));
  CHECK(nearest[0] == EightNearest{0, 1, 2, 3, 4, 5, 6, 7});
}

}  // namespace diffsac
