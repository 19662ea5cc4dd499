#include "lab/eval/run_files.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "lab/eval/eval_fixtures.h"
#include "lab/eval/tables.h"

namespace diffsac {
namespace {

using Catch::Contains;
using testing::MadeUpResults;

std::vector<Table> TablesOf(const ExperimentResults& results) { return MakeReport(results).tables; }
std::string MarkdownOf(const ExperimentResults& results) { return MarkdownReport(MakeReport(results)); }

TEST_CASE("the table in Markdown") {
  const std::vector<Table> tables = TablesOf(MadeUpResults());
  REQUIRE(tables.size() == 2);
  // Bins at .05 .. .5: errors of .045 .09 .135 .18 average .85, twice that .6; .12 .24 .36 .48 average .45.
  CHECK(MarkdownTable(tables[0]) ==
        "| method                     |       0.2 |       0.5 | hypotheses |  ms |\n"
        "|----------------------------|----------:|----------:|-----------:|----:|\n"
        "| First                      | **0.850** | **0.600** |         20 | 0.5 |\n"
        "| Second                     |     0.450 |     0.175 |         20 | 0.5 |\n"
        "| Oracle                     |     1.000 |     0.950 |          – |   – |\n"
        "| RANSAC (paper, other data) |      0.83 |      0.78 |            |     |\n");
}

TEST_CASE("the lowest median is the best, and the oracle does not compete") {
  const Table table = TablesOf(MadeUpResults())[1];
  CHECK(table.rows[0].best[1]);
  CHECK_FALSE(table.rows[1].best[1]);
  CHECK_FALSE(table.rows[2].best[1]);
  CHECK(table.rows[0].cells[1] == "0.113");
  CHECK(table.rows[3].cells[2] == "–");  // The paper gives no median there.
}

TEST_CASE("equal values are all best") {
  ExperimentResults results = MadeUpResults();
  results.cells[1].records = results.cells[0].records;
  const Table table = TablesOf(results)[0];
  CHECK(table.rows[0].best[1]);
  CHECK(table.rows[1].best[1]);
}

TEST_CASE("numbers of problems are shown when they differ") {
  ExperimentResults results = MadeUpResults();
  results.cells[1].records.pop_back();
  const Table table = TablesOf(results)[0];
  CHECK(table.columns.back() == "n");
  CHECK(table.rows[0].cells.back() == "4");
  CHECK(table.rows[1].cells.back() == "3–4");
}

TEST_CASE("data without ground truth shows inliers") {
  ExperimentResults results = MadeUpResults();
  for (Cell& cell : results.cells)
    for (ProblemRecord& record : cell.records) record.error = {std::nan(""), std::nan(""), false};
  const std::vector<Table> tables = TablesOf(results);
  REQUIRE(tables.size() == 1);
  CHECK(tables[0].rows[0].cells[1] == "20");
}

TEST_CASE("poses have tables of rotation, translation, areas, scenes and differences") {
  const std::vector<Table> tables = TablesOf(testing::MadeUpPoses());
  REQUIRE(tables.size() == 7);
  CHECK_THAT(tables[0].heading, Contains("mAA@10deg, unweighted mean over 2 scenes"));
  CHECK(tables[0].rows[0].cells[1] == "0.750");  // (1 + .5) / 2
  CHECK(tables[0].rows[1].cells[1] == "0.275");  // (.3 + .3 * 5 / 6) / 2
  CHECK(tables[1].heading == "mAA@10deg, mean over all pairs, higher is better");
  CHECK(tables[1].rows[0].cells[1] == "0.625");  // (2 * 1 + 6 * .5) / 8
  CHECK(tables[1].columns.size() == 2);
  CHECK(MarkdownTable(tables[3]) ==
        "| method | all: mAA@10deg | all: median degrees |\n"
        "|--------|---------------:|--------------------:|\n"
        "| First  |          0.750 |               2.750 |\n"
        "| Second |      **0.917** |           **0.000** |\n");
  CHECK(tables[3].heading == "rotation alone");
  CHECK(tables[4].heading == "translation alone");
  CHECK(tables[4].rows[0].cells[1] == "1.000");
  CHECK(tables[4].rows[1].cells[2] == "7.500");
  CHECK(tables[5].columns ==
        std::vector<std::string>{"method", "all: AUC@5deg", "all: AUC@10deg", "all: AUC@20deg", "all: failures"});
  CHECK(tables[5].rows[0].cells[4] == "0");
  CHECK(tables[5].rows[1].cells[4] == "1");
  CHECK(tables[6].columns == std::vector<std::string>{"method", "a", "b"});
  CHECK(tables[6].rows[0].cells == std::vector<std::string>{"First", "1.000", "0.500"});
  CHECK_THAT(MarkdownOf(testing::MadeUpPoses()), Contains("unweighted means over the scenes"));
}

TEST_CASE("many conditions have a table for each metric of poses") {
  ExperimentResults results = testing::MadeUpPoses();
  for (const char* name : {"2", "3", "4"}) {
    results.experiment.conditions.push_back(results.experiment.conditions.front());
    results.experiment.conditions.back().label = name;
  }
  const std::vector<Table> tables = TablesOf(results);
  REQUIRE(tables.size() == 12);  // 3, then 2 of rotation, 2 of translation, 4 of areas and failures, a scene table
  CHECK(tables[4].heading == "rotation alone, median degrees");
  CHECK(tables[4].columns == std::vector<std::string>{"method", "all", "2", "3", "4"});
  CHECK(tables[4].rows[0].cells == std::vector<std::string>{"First", "2.750", "–", "–", "–"});
  CHECK(tables[7].heading == "max(R, t), AUC@5deg");
  CHECK(tables[10].heading == "max(R, t), failures");
}

TEST_CASE("one scene needs no tables by scene") {
  ExperimentResults results = testing::MadeUpPoses();
  for (Cell& cell : results.cells)
    for (ProblemRecord& record : cell.records) record.scene = "a";
  const std::vector<Table> tables = TablesOf(results);
  REQUIRE(tables.size() == 5);
  CHECK(tables[0].heading == "mAA@10deg, higher is better");
}

TEST_CASE("several structures have tables of misclassification, recall and sets instead") {
  const ExperimentResults results = testing::MadeUpInstances();
  const std::vector<Table> tables = TablesOf(results);
  REQUIRE(tables.size() == 5);
  // Of 50 % on three problems and 25 % on one the mean is 43.75.
  CHECK(MarkdownTable(tables[0]) ==
        "| method                        |      0.2 |       0.5 | draws | hypotheses |  ms |\n"
        "|-------------------------------|---------:|----------:|------:|-----------:|----:|\n"
        "| First                         | **0.00** | **43.75** |    20 |         20 | 0.5 |\n"
        "| Second                        |    43.75 |     65.62 |     – |         20 | 0.5 |\n"
        "| Oracle                        |     0.00 |      0.00 |     – |          – |   – |\n"
        "| Published (paper, other data) |        – |      5.25 |       |            |     |\n");
  CHECK_THAT(MarkdownOf(results), Contains("Rows marked"));
  ExperimentResults same = results;
  same.experiment.paper[0].second.same_data = true;
  CHECK(TablesOf(same)[0].rows[3].cells[0] == "Published (published)");
  CHECK_THAT(MarkdownOf(same), !Contains("Rows marked") && !Contains("other data"));
  CHECK(tables[1].heading == "misclassification error in %, median, lower is better");
  CHECK(tables[1].rows[1].cells[2] == "75.00");
  CHECK(tables[2].heading == "recall of structures, higher is better");
  CHECK(tables[2].rows[0].cells[1] == "1.000");
  CHECK(tables[2].rows[0].best[1]);
  CHECK(tables[2].rows[1].intervals[1] == "[0.500, 0.500]");
  CHECK(tables[3].rows[1].cells[2] == "0.250 [0.250, 0.250]");
  CHECK(tables[3].rows[2].cells[2] == "–");
  CHECK(tables[3].rows[0].best[1]);
  CHECK_THAT(MarkdownOf(results), Contains("per cent of points with a wrong label") && !Contains("mAA"));
}

TEST_CASE("structures of several scenes: errors over all problems, as the papers have them") {
  ExperimentResults results = testing::MadeUpInstances();
  for (Cell& cell : results.cells) cell.records[0].scene = "another";
  const std::vector<Table> tables = TablesOf(results);
  CHECK(tables[0].rows[0].cells[2] == "43.75");
  CHECK_THAT(tables[2].heading, Contains("unweighted mean over 2 scenes"));
  CHECK(tables[5].heading == "misclassification error in % by scene, outlier ratio 0.2");
  CHECK(tables[6].rows[0].cells == std::vector<std::string>{"First", "25.00", "50.00"});
}

TEST_CASE("no number is printed as a long row of digits") {
  CHECK(FixedText(0.12345, 3) == "0.123");
  CHECK(FixedText(123456.0, 1) == "123456.0");
  CHECK(FixedText(1e300, 3) == "1e+300");
  CHECK(FixedText(-1.5e12, 2) == "-1.5e+12");
  CHECK(FixedText(std::nan(""), 2) == kUnknown);
  ExperimentResults results = MadeUpResults();
  for (ProblemRecord& record : results.cells[0].records) record.error.angle_deg = 1e300;
  for (const Table& table : MakeReport(results).tables)
    for (const Table::Row& row : table.rows)
      for (const std::string& cell : row.cells) CHECK(cell.size() < 40);
}

TEST_CASE("the report says what is partial and what is the paper's") {
  ExperimentResults results = MadeUpResults();
  CHECK_THAT(MarkdownOf(results), !Contains("Partial") && Contains("other data") && Contains("Small lines"));
  results.partial = true;
  CHECK_THAT(MarkdownOf(results), Contains("Partial results"));
}

}  // namespace
}  // namespace diffsac
