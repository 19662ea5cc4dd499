#include "lab/eval/report.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "lab/eval/factor_fixtures.h"

namespace diffsac {
namespace {

using namespace testing;

/// Rows plain_few, plain_some, plain_many, good_few, good_some, good_many: errors of 5.5 degrees (accuracy .5), one
/// less for each step of `draws`, three less for `good`.
ExperimentResults Additive() {
  return MadeUpFactors(
      [](std::size_t, std::size_t m, int) { return 5.5 - static_cast<double>(m % 3) - (m < 3 ? 0.0 : 3.0); });
}

TEST_CASE("an effect is the difference to the factor's first level, averaged over the other factors") {
  const FactorEffects effects = EffectsOf(Additive(), 0);
  REQUIRE(effects.size() == 2);
  REQUIRE(effects[0].size() == 2);
  REQUIRE(effects[1].size() == 3);
  CHECK(effects[0][0].combinations == 3);
  CHECK(effects[0][0].accuracy->mean == Approx(0.6));  // of .5, .6 and .7
  CHECK(effects[0][1].accuracy->mean == Approx(0.3));
  CHECK(effects[1][0].accuracy->mean == Approx(0.65));
  CHECK(effects[1][1].accuracy->mean == Approx(0.1));
  CHECK(effects[1][2].accuracy->mean == Approx(0.2));
  CHECK(effects[1][2].combinations == 2);
}

TEST_CASE("milliseconds are ratios of geometric means") {
  const FactorEffects effects = EffectsOf(Additive(), 1);
  CHECK(effects[0][0].milliseconds->mean == Approx(0.5));
  CHECK(effects[0][1].milliseconds->mean == Approx(10.0));
  CHECK(effects[1][0].milliseconds->mean == Approx(std::sqrt(0.5 * 5.0)));
  CHECK(effects[1][2].milliseconds->mean == Approx(1.0));
  CHECK(effects[1][2].milliseconds->low == Approx(1.0));
  ExperimentResults untimed = Additive();
  for (Cell& cell : untimed.cells)
    for (ProblemRecord& record : cell.records) record.stats.ms_total = 0.0;
  CHECK_FALSE(EffectsOf(untimed, 0)[0][1].milliseconds);
}

TEST_CASE("scenes weigh the same, however many problems they have") {
  // `good` is right in scene a (four of twelve problems) and does nothing in b.
  const ExperimentResults results =
      MadeUpFactors([](std::size_t, std::size_t m, int i) { return m >= 3 && i < 4 ? 0.0 : 90.0; });
  CHECK(EffectsOf(results, 0)[0][1].accuracy->mean == Approx(0.5));
}

TEST_CASE("the effects of a table of one factor are its paired comparisons") {
  ExperimentResults results = MixedFactors();
  results.experiment.factors = {{"row", {"plain_few", "plain_some", "good_many"}}};
  const std::vector<std::size_t> rows = {0, 1, 5};
  for (std::size_t c = 0; c < 2; ++c) {
    const FactorEffects effects = EffectsOf(results, c);
    REQUIRE(effects.size() == 1);
    for (std::size_t l = 1; l < rows.size(); ++l) {
      const auto difference = DifferenceOf(results, c, rows[l], rows[0]);
      REQUIRE(difference);
      CHECK(effects[0][l].accuracy->mean == difference->mean);
      CHECK(effects[0][l].accuracy->low == difference->low);
      CHECK(effects[0][l].accuracy->high == difference->high);
      CHECK(effects[0][l].combinations == 1);
    }
  }
}

TEST_CASE("a combination that one of the two levels has not is left out") {
  ExperimentResults results = Additive();
  results.cells[3].records.clear();    // good_few
  results.cells[2].records.resize(1);  // plain_many: the first problem
  const FactorEffects effects = EffectsOf(results, 0);
  CHECK(effects[0][1].combinations == 2);
  CHECK(effects[0][1].accuracy->mean == Approx(0.3));
  results.cells.erase(results.cells.begin(), results.cells.begin() + 3);  // All of `plain`.
  const FactorEffects without = EffectsOf(results, 0);
  CHECK(without[0][1].combinations == 0);
  CHECK_FALSE(without[0][1].accuracy);
  CHECK_FALSE(without[0][0].accuracy);
  CHECK(without[1][1].combinations == 0);  // good_few, the first, is empty.
}

TEST_CASE("failures count, problems without truth do not") {
  ExperimentResults results = Additive();
  for (std::size_t i = 0; i < 6; ++i) {
    results.cells[i].records[0].error = {};  // Of all rows: scene a has three problems left.
    results.cells[i].records[1].error.failed = i == 3;
  }
  results.cells[3].records[1].error.angle_deg = 180.0;
  // good_few loses .8 in one of three problems of one of two scenes, in one of three combinations.
  CHECK(EffectsOf(results, 0)[0][1].accuracy->mean == Approx(0.3 - 0.8 / 18.0));
  for (Cell& cell : results.cells)
    for (ProblemRecord& record : cell.records) record.error = {};
  const FactorEffects unknown = EffectsOf(results, 0);
  CHECK_FALSE(unknown[0][1].accuracy);
  CHECK(unknown[0][1].milliseconds->mean == Approx(10.0));
}

TEST_CASE("without factors there are no effects") { CHECK(EffectsOf(MadeUpResults(), 0).empty()); }

}  // namespace
}  // namespace diffsac
