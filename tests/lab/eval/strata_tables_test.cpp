#include "lab/eval/strata_tables.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "lab/eval/effect_tables.h"
#include "lab/eval/factor_fixtures.h"
#include "lab/eval/long_lines.h"
#include "lab/eval/markdown_report.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

/// `good` rows are right everywhere, `plain` ones where at least half of the points are inliers.
ExperimentResults HardAndEasy() {
  return MadeUpFactors([](std::size_t, std::size_t m, int i) { return m >= 3 || i >= 6 ? 0.0 : 90.0; });
}

TEST_CASE("a table of strata has a column a bin, with counts, and the best of it in bold") {
  const ExperimentResults results = HardAndEasy();
  const Report report = MakeReport(results);
  const std::vector<Table> tables = StrataTables(report);
  REQUIRE(tables.size() == 6);  // Two conditions: the accuracy, the comparison, the effects.
  CHECK(tables[0].heading == "mAA@10deg by share of true inliers (problems), matches all");
  CHECK(tables[3].heading == "mAA@10deg by share of true inliers (problems), matches ratio");
  CHECK(tables[0].columns == std::vector<std::string>{"method", "< 0.2 (3)", "0.2–0.5 (3)", "≥ 0.5 (6)"});
  REQUIRE(tables[0].rows.size() == 6);
  CHECK(tables[0].rows[0].cells == std::vector<std::string>{"plain, few", "0.000", "0.000", "1.000"});
  CHECK(tables[0].rows[0].best == std::vector<bool>{false, false, false, true});
  CHECK(tables[0].rows[3].best == std::vector<bool>{false, true, true, true});
  CHECK(tables[0].rows[0].intervals == std::vector<std::string>{"", "", "", "[1.000, 1.000]"});
}

TEST_CASE("comparisons and effects are within their bins; few problems tell no interval") {
  const ExperimentResults results = HardAndEasy();
  const Report report = MakeReport(results);
  const std::vector<Table> tables = StrataTables(report);
  CHECK(tables[1].rows[0].cells ==
        std::vector<std::string>{"good, many − plain, few", "+1.000", "+1.000", "+0.000 [+0.000, +0.000]"});
  CHECK(tables[1].rows[0].best == std::vector<bool>{false, false, false, false});
  CHECK(tables[2].columns[1] == "< 0.2 (3)");
  CHECK(tables[2].rows[1].cells ==
        std::vector<std::string>{"score: good", "+1.000", "+1.000", "+0.000 [+0.000, +0.000]"});
}

TEST_CASE("in a bin every problem weighs the same") {
  // Of the bin from .2 to .5 problem 3 is of scene a, problems 4 and 5 of scene b.
  const ExperimentResults results = MadeUpFactors([](std::size_t, std::size_t, int i) { return i == 3 ? 0.0 : 90.0; });
  CHECK(StrataTables(MakeReport(results))[0].rows[0].cells[2] == "0.333");
}

TEST_CASE("what is unknown is said, and has no table") {
  ExperimentResults results = HardAndEasy();
  results.experiment.strata = {{Quantity::kBaseline, {1.0}, {}}};
  CHECK(StrataTables(MakeReport(results)).empty());
  CHECK_THAT(StrataNote(MakeReport(results)), Contains("Strata by true baseline are left out"));
  CHECK_THAT(MarkdownReport(MakeReport(results)), Contains("Strata by true baseline are left out"));
  results.experiment.strata = {{Quantity::kInlierShare, {0.5}, {}}};
  for (std::size_t i = 0; i < 6; ++i) results.cells[i].records[2].inlier_share = std::nan("");
  CHECK_THAT(StrataNote(MakeReport(results)),
             Contains("In no stratum, as their share of true inliers is unknown: all 1 problems."));
  for (Cell& cell : results.cells)
    for (ProblemRecord& record : cell.records) record.error = {};
  CHECK(StrataTables(MakeReport(results)).empty());
  CHECK(StrataNote(MakeReport(results)) == "Strata are left out: the truth is not known.\n");
  results.experiment.strata.clear();
  CHECK(StrataNote(MakeReport(results)).empty());
}

TEST_CASE("strata are shown for the rows that they name; scenes have their own table already") {
  ExperimentResults results = HardAndEasy();
  results.experiment.strata = {{Quantity::kPoints, {50.0}, {"good_few", "plain_few"}}, {Quantity::kScene, {}, {}}};
  const std::vector<Table> tables = StrataTables(MakeReport(results));
  REQUIRE(tables.size() == 10);
  REQUIRE(tables[0].rows.size() == 2);
  CHECK(tables[0].rows[0].cells[0] == "good, few");
  CHECK(tables[0].columns[1] == "< 50 (5)");
  CHECK(tables[6].heading == "differences in mAA@10deg by scene (problems), matches all");
  CHECK(tables[6].columns == std::vector<std::string>{"A minus B", "a (4)", "b (8)"});
  CHECK(tables[7].heading == "effects on mAA@10deg by scene (problems), matches all");
}

TEST_CASE("tables of effects: the first level's mean, what the others add, how much longer they take") {
  const ExperimentResults results = HardAndEasy();
  const std::vector<Table> tables = EffectTables(MakeReport(results));
  REQUIRE(tables.size() == 2);
  CHECK_THAT(tables[0].heading, Contains("effects on mAA@10deg"));
  CHECK(tables[0].columns == std::vector<std::string>{"factor: level", "all", "ratio"});
  REQUIRE(tables[0].rows.size() == 5);
  CHECK_THAT(tables[0].rows[0].cells[1], Catch::StartsWith("0.375 [0."));  // (0 + 6 / 8) / 2
  CHECK_THAT(tables[0].rows[1].cells[1], Catch::StartsWith("+0.625 [+0."));
  CHECK(tables[0].rows[1].best[1]);
  CHECK_FALSE(tables[0].rows[0].best[1]);
  CHECK(tables[0].rows[3].cells[2] == "+0.000 [+0.000, +0.000]");
  CHECK(tables[1].rows[0].cells[1] == "0.5 ms [0.5, 0.5]");
  CHECK(tables[1].rows[1].cells[1] == "×10 [10, 10]");
  CHECK(tables[1].rows[1].best[1]);
  const ExperimentResults without = MadeUpResults();
  CHECK(EffectTables(MakeReport(without)).empty());
  CHECK_THAT(MarkdownReport(MakeReport(results)), Contains("score: good") && Contains("Effects: the first level"));
}

TEST_CASE("levels that some rows are missing of are named") {
  ExperimentResults results = HardAndEasy();
  CHECK(MissingCombinations(MakeReport(results)).empty());
  results.cells[11].records.clear();  // good_many on the second condition
  CHECK(MissingCombinations(MakeReport(results)) == "Of fewer combinations: score: good 2 of 3, draws: many 1 of 2.\n");
  CHECK_THAT(MarkdownReport(MakeReport(results)), Contains("score: good 2 of 3"));
}

TEST_CASE("results.csv has effects and strata, each by its name") {
  const ExperimentResults results = HardAndEasy();
  LongLines effects(results), strata(results);
  const Report report = MakeReport(results);
  AddEffectLines(report.effects, "mean", &effects);
  CHECK_THAT(effects.text(), Contains("factors,synthetic_two_view,mean,all,score=good,mAA@10deg,0.625\n") &&
                                 Contains(",mean,all,score=good,mAA@10deg_low,0.") &&
                                 Contains(",mean,ratio,score=good,ms,10\n") &&
                                 Contains(",mean,all,draws=some,combinations,2\n"));
  AddStrataLines(report, &strata);
  CHECK_THAT(strata.text(), Contains(",inlier_share below 0.2,all,plain_few,mAA@10deg,0\n") &&
                                Contains(",inlier_share 0.2-0.5,ratio,good_many,problems,3\n") &&
                                Contains(",inlier_share from 0.5,all,good_many - plain_few,mAA@10deg_high,0\n") &&
                                Contains(",inlier_share below 0.2,all,score=good,mAA@10deg,1\n") &&
                                !Contains("below 0.2,all,score=good,mAA@10deg_low"));
}

}  // namespace
}  // namespace diffsac
