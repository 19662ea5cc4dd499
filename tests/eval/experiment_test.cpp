#include "diffsac/eval/experiment.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "diffsac/core/status.h"
#include "eval/eval_fixtures.h"

namespace diffsac {
namespace {

using Catch::Contains;
using testing::kSmallExperiment;
using testing::SmallExperiment;

std::string With(const std::string& from, const std::string& to) {
  std::string text = kSmallExperiment;
  text.replace(text.find(from), from.size(), to);
  return text;
}

ExperimentOptions Read(const std::string& text) { return ReadExperiment(Config::FromString(text, "x.yaml")); }

TEST_CASE("an experiment is read with its lists") {
  const ExperimentOptions experiment = SmallExperiment();
  REQUIRE(experiment.conditions.size() == 2);
  CHECK(experiment.conditions[1].value == 0.5);
  CHECK_THAT(experiment.conditions[1].data.Dump(), Contains("num_points: 30") && Contains("outlier_ratio: 0.5"));
  CHECK_THAT(experiment.conditions[0].data.Dump(), Contains("outlier_ratio: 0.2"));
  REQUIRE(experiment.methods.size() == 3);
  CHECK(experiment.methods[1].max_problems == 10);
  CHECK_FALSE(experiment.methods[1].config.Has("max_problems"));
  REQUIRE(experiment.paper.size() == 1);
  CHECK(experiment.paper[0].values.at("0.2").median_deg == 0.06);
  CHECK(std::isnan(experiment.paper[0].values.at("0.5").median_deg));
}

TEST_CASE("the paper's values of rotation and translation apart") {
  const auto experiment = Read(With("\"0.5\": 0.78", "\"0.5\": {R: 0.7, t: 0.6, median_t: 2.5}"));
  const PaperValue& value = experiment.paper[0].values.at("0.5");
  CHECK(value.rotation == 0.7);
  CHECK(value.translation == 0.6);
  CHECK(value.median_translation_deg == 2.5);
  CHECK(std::isnan(value.median_rotation_deg));
  CHECK(std::isnan(value.accuracy));
  CHECK_THROWS_WITH(Read(With("\"0.5\": 0.78", "\"0.5\": {r: 0.7}")), Contains("median_R") && Contains("x.yaml"));
}

TEST_CASE("the written experiment reads back to the same") {
  const std::string once = WriteExperiment(SmallExperiment());
  CHECK(WriteExperiment(Read(once)) == once);
  CHECK_THAT(once, Contains("min_extent"));  // Defaults of the data are filled in.
}

TEST_CASE("mistakes name the file, the line and the nearest name") {
  CHECK_THROWS_WITH(Read(With("problems: 40", "problem: 40")), Contains("x.yaml:5") && Contains("problems"));
  CHECK_THROWS_WITH(Read(With("problems: 40", "problems: none")), Contains("x.yaml:5") && Contains("integer"));
  CHECK_THROWS_WITH(Read(With("name: second", "name: first")), Contains("stands twice"));
  CHECK_THROWS_WITH(Read(With("max_problems: 10", "conditions: [\"0.25\"]")), Contains("did you mean '0.2'"));
  CHECK_THROWS_WITH(Read(With("\"0.5\": 0.78", "\"0.5\": abc")), Contains("expected a number"));
  CHECK_THROWS_WITH(Read("name: x\ndata: {type: synthetic_line}\n"), Contains("list of methods"));
  CHECK_THROWS_WITH(Read("methods: [{name: a}]\n"), Contains("type"));
}

TEST_CASE("an optional row without its checkpoint is left out, and named") {
  ExperimentOptions experiment = SmallExperiment();
  const std::size_t rows = experiment.methods.size();
  const std::string text = With("methods:", "methods:\n  - {name: learned, type: diffsac, label: Learned, optional: true, "
                                            "checkpoint: there/is/no.pt}");
  experiment = Read(text);
  REQUIRE(experiment.methods.size() == rows + 1);
  LeaveOutUnavailable(&experiment);
  CHECK(experiment.methods.size() == rows);
  REQUIRE(experiment.left_out.size() == 1);
  CHECK(experiment.left_out[0] == "Learned (needs there/is/no.pt)");
  // Without `optional` it stays, and the run fails with the missing file.
  std::string required = text;
  required.replace(required.find("optional: true"), 14, "optional: false");
  experiment = Read(required);
  LeaveOutUnavailable(&experiment);
  CHECK(experiment.methods.size() == rows + 1);
  CHECK(experiment.left_out.empty());
}

TEST_CASE("an optional condition without its data is left out with the rows for it alone, and named") {
  const char* text = R"(
name: descriptors
task: fundamental
data: {type: synthetic_two_view, task: fundamental}
conditions:
  - {name: here}
  - {name: absent, label: Absent, optional: true, data: {type: correspondences, paths: [no/such/pairs]}}
methods:
  - {name: both, type: ransac}
  - {name: here_alone, type: ransac, conditions: [here]}
  - {name: absent_alone, type: ransac, label: Lost, conditions: [absent]}
reference: absent_alone
compare: [[both, absent_alone]]
figures: {qualitative_conditions: [absent], confidence_condition: absent}
paper: {Theirs: {ours: absent_alone, here: 0.5, absent: 0.6}}
)";
  ExperimentOptions experiment = Read(text);
  CHECK(Read(WriteExperiment(experiment)).conditions[1].optional);
  LeaveOutUnavailable(&experiment);
  REQUIRE(experiment.conditions.size() == 1);
  REQUIRE(experiment.methods.size() == 2);
  CHECK(experiment.methods[1].name == "here_alone");
  REQUIRE(experiment.left_out.size() == 2);
  CHECK_THAT(experiment.left_out[0], Contains("Absent") && Contains("no/such/pairs"));
  CHECK_THAT(experiment.left_out[1], Contains("Lost"));
  CHECK(experiment.compare.empty());
  CHECK(experiment.paper[0].values.size() == 1);
  CHECK_NOTHROW(Read(WriteExperiment(experiment)));  // nothing refers to what is left out

  experiment = Read(text);
  experiment.conditions.erase(experiment.conditions.begin());
  CHECK_THROWS_WITH(LeaveOutUnavailable(&experiment), Contains("no condition is left"));
}

TEST_CASE("rows are selected by name, in the experiment's order") {
  ExperimentOptions experiment = SmallExperiment();
  SelectMethods({"oracle", "first"}, &experiment);
  REQUIRE(experiment.methods.size() == 2);
  CHECK(experiment.methods[0].name == "first");
  CHECK_THROWS_WITH(SelectMethods({"orcale"}, &experiment), Contains("--methods") && Contains("'oracle'"));
}

TEST_CASE("comparisons and groups of scenes are read, written and checked") {
  const std::string more =
      "compare: [[first, second], [oracle, first]]\nscene_groups: {kitti: [k_1, k_2_*], other: \"o?\"}\n";
  ExperimentOptions experiment = Read(kSmallExperiment + more);
  REQUIRE(experiment.compare.size() == 2);
  CHECK(experiment.compare[1].a == "oracle");
  CHECK(experiment.RowOf("second") == 1);
  CHECK(experiment.RowOf("third") == 3);
  CHECK(experiment.GroupOf("k_1") == "kitti");
  CHECK(experiment.GroupOf("k_2_x") == "kitti");
  CHECK(experiment.GroupOf("k_3") == "k_3");
  CHECK(experiment.GroupOf("o1") == "other");
  CHECK(SmallExperiment().GroupOf("k_1") == "k_1");
  const std::string once = WriteExperiment(experiment);
  CHECK(WriteExperiment(Read(once)) == once);
  CHECK_THAT(once, Contains("k_2_*") && Contains("compare"));
  SelectMethods({"first", "second"}, &experiment);
  CHECK(experiment.compare.size() == 1);
  CHECK_THROWS_WITH(Read(kSmallExperiment + std::string("compare: [[first, secund]]\n")),
                    Contains("x.yaml:17") && Contains("did you mean 'second'"));
  CHECK_THROWS_WITH(Read(kSmallExperiment + std::string("compare: [[first]]\n")), Contains("two methods"));
  CHECK_THROWS_WITH(Read(kSmallExperiment + std::string("scene_groups: [a, b]\n")), Contains("expected a map"));
}

TEST_CASE("every shipped table can be read") {
  for (const auto& entry : std::filesystem::directory_iterator(DIFFSAC_SOURCE_DIR "/configs/tables")) {
    if (entry.path().extension() != ".yaml") continue;
    INFO(entry.path().string());
    const ExperimentOptions experiment = ReadExperiment(Config::FromFile(entry.path().string()));
    CHECK(experiment.name == entry.path().stem().string());
    CHECK_FALSE(WriteExperiment(experiment).empty());
  }
}

}  // namespace
}  // namespace diffsac
