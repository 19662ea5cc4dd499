#include "lab/report/effects_page.h"

#include <catch2/catch.hpp>

#include <deque>
#include <filesystem>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/eval/factor_fixtures.h"
#include "lab/report/interval_table.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

ExperimentResults Named(const std::string& name) {
  ExperimentResults results = MixedFactors();
  results.experiment.name = name;
  results.experiment.title = "Title of " + name;
  return results;
}

TEST_CASE("experiments are called by what tells them apart") {
  using Texts = std::vector<std::string>;
  CHECK(ShortNames({"scoreboard_line", "scoreboard_absolute_pose"}) == Texts{"line", "absolute_pose"});
  CHECK(ShortNames({"scoreboard_line", "scoreboard_linear"}) == Texts{"line", "linear"});
  CHECK(ShortNames({"a_b", "c_d"}) == Texts{"a_b", "c_d"});
  CHECK(ShortNames({"only_one"}) == Texts{"only_one"});
  CHECK(ShortNames({}).empty());
}

TEST_CASE("the overview has every level of any run, a column a run and condition") {
  std::deque<ExperimentResults> results = {Named("t_one"), Named("t_two")};
  results[1].experiment.factors = {{"score", {"plain", "good", "best"}}};
  results[1].experiment.conditions.resize(1);
  std::vector<EffectRun> runs;
  for (const ExperimentResults& one : results) runs.push_back({"", MakeReport(one)});
  const std::vector<Table> tables = EffectOverview(runs);
  REQUIRE(tables.size() == 2);
  CHECK(tables[0].columns == std::vector<std::string>{"factor: level", "one: all", "one: ratio", "two"});
  std::vector<std::string> names;
  for (const Table::Row& row : tables[0].rows) names.push_back(row.cells[0]);
  CHECK(names == std::vector<std::string>{"score: plain (first)", "score: good", "score: best", "draws: few (first)",
                                          "draws: some", "draws: many"});
  CHECK(tables[0].rows[0].cells[1] == kUnknown);
  CHECK(tables[0].rows[1].cells[1] ==
        IntervalText(*runs[0].report.effects[0][0][1].accuracy, IntervalKind::kDifference));
  CHECK(tables[0].rows[2].cells[3] == kUnknown);  // No row is named `best`.
  CHECK(tables[1].rows[1].cells[2] == "×10 [10, 10]");
}

TEST_CASE("the best rows come first, references are none of them") {
  ExperimentResults results = MadeUpFactors([](std::size_t, std::size_t m, int) {
    return m == 4 ? 0.0 : m == 1 ? 2.5 : 9.5;
  });
  results.experiment.methods[5].type = "oracle";
  for (ProblemRecord& record : results.cells[5].records) record.error.angle_deg = 0.0;
  const Table table = BestRows(MakeReport(results), 0);
  REQUIRE(table.rows.size() == 5);
  CHECK(table.rows[0].cells == std::vector<std::string>{"good, some", "1.000 [1.000, 1.000]", "0", "5"});
  CHECK(table.rows[1].cells[0] == "plain, some");
  CHECK(table.heading == "best rows, matches all");
}

TEST_CASE("the page has each run's effects, best rows, strata and pictures, and names what is not made") {
  const TemporaryFolder folder;
  WriteRun(Named("t_one"), folder.File("t_one"), "# seed: 4\n# date: today\n\n");
  ExperimentResults two = Named("t_two");
  two.experiment.left_out = {"Absent (needs no.safetensors)"};
  WriteRun(two, folder.File("t_two"));
  WriteFileAtomically(folder.File("t_one/effects.png"), "picture");
  std::filesystem::create_directories(folder.File("t_three"));
  std::ostringstream out;
  const std::string page = folder.File("docs/page.md");
  WriteEffectsPage({folder.File("t_one/"), folder.File("t_two"), folder.File("t_three"), folder.File("t_four")}, page,
                   "make it", out);
  const std::string text = ReadFile(page);
  CHECK(out.str() == text);
  CHECK_THAT(text, Contains("Written by `make it`") && Contains("Not made: t_three.") &&
                       Contains("Not made: t_four.") && Contains("## Title of t_one") &&
                       Contains("## Title of t_two") && Contains("### best rows") &&
                       Contains("by share of true inliers (problems)") && Contains("Left out: Absent") &&
                       Contains("](page_t_one_effects.png)") && Contains("- date: today") && Contains("one: ratio"));
  CHECK(ReadFile(folder.File("docs/page_t_one_effects.png")) == "picture");
  std::ostringstream again;
  WriteEffectsPage({folder.File("t_one")}, "", "make it", again);
  CHECK_THAT(again.str(), Contains("## Title of t_one") && !Contains(".png"));
}

TEST_CASE("a run without factors, and no run at all, are errors") {
  const TemporaryFolder folder;
  std::ostringstream out;
  WriteRun(MadeUpResults(), folder.File("plain"));
  CHECK_THROWS_WITH(WriteEffectsPage({folder.File("plain")}, "", "", out), Contains("has no 'factors'"));
  CHECK_THROWS_WITH(WriteEffectsPage({folder.File("none")}, "", "", out), Contains("none of these folders"));
}

}  // namespace
}  // namespace diffsac
