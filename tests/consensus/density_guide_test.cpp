#include "diffsac/consensus/samplers/density_guide.h"

#include <catch2/catch.hpp>
#include <set>
#include <vector>

namespace diffsac {
namespace {

Eigen::VectorXd Densities(std::initializer_list<double> values) {
  Eigen::VectorXd result(values.size());
  std::copy(values.begin(), values.end(), result.begin());
  return result;
}

TEST_CASE("points prefer the hypotheses they are densest in, the earlier one where equal") {
  DensityGuide guide(3, 2);
  guide.Add(Densities({1.0, 5.0, 0.0}));
  guide.Add(Densities({3.0, 1.0, 0.0}));
  guide.Add(Densities({2.0, 1.0, 4.0}));
  CHECK(guide.Explanation(0) == 5.0);
  CHECK(guide.Explanation(1) == 6.0);
  CHECK(guide.Explanation(2) == 4.0);
  // Point 0: hypotheses 1 and 2; point 1: 0 and 1; point 2: 2 alone.
  CHECK(guide.Correlation(0, 1) == 0.5);
  CHECK(guide.Correlation(0, 2) == 0.5);
  CHECK(guide.Correlation(1, 2) == 0.0);
  CHECK(guide.Correlation(0, 0) == 1.0);
  CHECK(guide.Preferred() == std::vector<int>{0, 1, 2});
}

TEST_CASE("sets are drawn among points that share preferences") {
  DensityGuide guide(6, 1);
  guide.Add(Densities({9.0, 9.0, 9.0, 1.0, 1.0, 1.0}));
  guide.Add(Densities({1.0, 1.0, 1.0, 9.0, 9.0, 9.0}));
  int set[3];
  Rng rng(3);
  guide.StartRound();
  for (int i = 0; i < 50; ++i) {
    guide.Draw(1, 3, rng, set);
    CHECK(std::vector<int>(set, set + 3) == std::vector<int>{0, 1, 2});
    guide.Draw(4, 2, rng, set);
    CHECK(set[0] >= 3);
    CHECK(set[0] < set[1]);
  }
}

TEST_CASE("without correlated points the rest of a set is uniform") {
  DensityGuide guide(5, 2);
  guide.StartRound();
  Rng rng(1);
  std::set<std::vector<int>> seen;
  int set[2];
  for (int i = 0; i < 200; ++i) {
    guide.Draw(2, 2, rng, set);
    CHECK((set[0] == 2 || set[1] == 2));
    CHECK(set[0] < set[1]);
    seen.insert({set[0], set[1]});
  }
  CHECK(seen.size() == 4);
  // One correlated point only: it is taken, then any other.
  guide.Add(Densities({0.0, 0.0, 1.0, 1.0, 0.0}));
  guide.StartRound();
  int three[3];
  for (int i = 0; i < 50; ++i) {
    guide.Draw(2, 3, rng, three);
    CHECK(std::count(three, three + 3, 3) == 1);
    CHECK(std::set<int>(three, three + 3).size() == 3);
  }
}

TEST_CASE("a round's sets know nothing of what the round itself adds") {
  DensityGuide guide(10, 1);
  guide.StartRound();
  guide.Add(Densities({9, 9, 0, 0, 0, 0, 0, 0, 0, 0}));
  Rng rng(2);
  std::set<int> partners;
  int set[2];
  for (int i = 0; i < 200; ++i) {
    guide.Draw(0, 2, rng, set);
    partners.insert(set[1]);
  }
  CHECK(partners.size() == 9);
}

}  // namespace
}  // namespace diffsac
