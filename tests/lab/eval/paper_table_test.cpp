#include "lab/eval/paper_table.h"
#include "lab/config/yaml.h"

#include <catch2/catch.hpp>

#include "lab/eval/eval_fixtures.h"

namespace diffsac {
namespace {

TEST_CASE("ours stands beside the paper's with its interval, difference and number") {
  ExperimentResults results = testing::MadeUpResults();
  CHECK(PaperTable(MakeReport(results)).rows.empty());  // The paper's row names none of ours.
  results.experiment.paper[0].second.ours = results.experiment.methods[0].name;
  const Table table = PaperTable(MakeReport(results));
  REQUIRE(table.rows.size() == 2);
  const auto& cells = table.rows[0].cells;
  REQUIRE(cells.size() == table.columns.size());
  CHECK(cells[0] == "First / RANSAC");
  CHECK(cells[1] == "0.2");
  CHECK(cells[2] == "mAA");
  CHECK(cells[3] == "0.83");
  CHECK(cells[4].substr(0, 7) == "0.850 [");
  CHECK(cells[5] == "+0.020");
  CHECK(cells[6] == "4");
  CHECK(table.rows[1].cells[5] == "-0.180");
}

TEST_CASE("two views: rotation and translation apart") {
  ExperimentResults results = testing::MadeUpPoses();
  PaperRow paper;
  paper.ours = "second";
  paper.values["all"].rotation = 0.5;
  paper.values["all"].translation = 0.25;
  results.experiment.paper.push_back({"DiffSAC", paper});
  const Table table = PaperTable(MakeReport(results));
  REQUIRE(table.rows.size() == 2);
  CHECK(table.rows[0].cells[2] == "mAA of R");
  CHECK(table.rows[1].cells[2] == "mAA of t");
  // 7.5 degrees of translation everywhere: three of ten thresholds.
  CHECK(table.rows[1].cells[4].substr(0, 3) == "0.2");
}

TEST_CASE("a row of the paper that names no row of ours is refused") {
  std::string text = testing::kSmallExperiment;
  text.replace(text.find("RANSAC: {"), 9, "RANSAC: {ours: frist, ");
  CHECK_THROWS_WITH(ReadExperiment(ConfigFromYaml(text, "x.yaml")), Catch::Contains("first"));
}

}  // namespace
}  // namespace diffsac
