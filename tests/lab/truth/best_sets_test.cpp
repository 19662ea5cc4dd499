#include "lab/truth/best_sets.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {

TEST_CASE("the best sets are the same in whatever order they come, those of one cost too") {
  using Set = std::array<int, 2>;
  std::vector<std::pair<double, Set>> offers;
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j) offers.push_back({static_cast<double>((i + j) % 3), {i, j}});
  auto sorted = offers;
  std::sort(sorted.begin(), sorted.end());
  Rng rng(4);
  for (int trial = 0; trial < 50; ++trial) {
    for (std::size_t k = offers.size(); k > 1; --k) std::swap(offers[k - 1], offers[rng.Below(k)]);
    BestSets<2> best(7);
    CHECK(best.bound() == std::numeric_limits<double>::infinity());
    for (const auto& [cost, set] : offers) best.Offer(cost, set);
    best.Offer(sorted[3].first, sorted[3].second);  // Known already.
    REQUIRE(best.entries().size() == 7);
    for (std::size_t k = 0; k < 7; ++k) {
      CHECK(best.entries()[k].cost == sorted[k].first);
      CHECK(best.entries()[k].set == sorted[k].second);
    }
    CHECK(best.bound() == sorted[6].first);
  }
  BestSets<2> none(0);
  none.Offer(1.0, {0, 1});
  CHECK(none.entries().empty());
}

}  // namespace diffsac
