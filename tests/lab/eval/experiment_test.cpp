#include "lab/eval/experiment.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/eval/eval_fixtures.h"

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

ExperimentOptions Read(const std::string& text) { return ReadExperiment(ConfigFromYaml(text, "x.yaml")); }

TEST_CASE("an experiment is read with its lists") {
  const ExperimentOptions experiment = SmallExperiment();
  REQUIRE(experiment.conditions.size() == 2);
  CHECK(experiment.conditions[1].value == 0.5);
  CHECK_THAT(ToYaml(experiment.conditions[1].data), Contains("num_points: 30") && Contains("outlier_ratio: 0.5"));
  CHECK_THAT(ToYaml(experiment.conditions[0].data), Contains("outlier_ratio: 0.2"));
  REQUIRE(experiment.methods.size() == 3);
  CHECK(experiment.methods[1].max_problems == 10);
  CHECK_FALSE(experiment.methods[1].config.Has("max_problems"));
  REQUIRE(experiment.paper.size() == 1);
  CHECK(experiment.paper[0].second.values.at("0.2").median_deg == 0.06);
  CHECK_FALSE(experiment.paper[0].second.values.at("0.5").median_deg);
}

TEST_CASE("the paper's values of rotation and translation apart") {
  const auto experiment = Read(With("\"0.5\": 0.78", "\"0.5\": {R: 0.7, t: 0.6, median_t: 2.5}"));
  const PaperValue& value = experiment.paper[0].second.values.at("0.5");
  CHECK(value.rotation == 0.7);
  CHECK(value.translation == 0.6);
  CHECK(value.median_translation_deg == 2.5);
  CHECK_FALSE(value.median_rotation_deg);
  CHECK_FALSE(value.accuracy);
  CHECK_THROWS_WITH(Read(With("\"0.5\": 0.78", "\"0.5\": {r: 0.7}")), Contains("x.yaml:16") && Contains("'R'"));
}

TEST_CASE("the written experiment reads back to the same") {
  const std::string once = WriteExperiment(SmallExperiment());
  CHECK(WriteExperiment(Read(once)) == once);
  CHECK_THAT(once, Contains("min_extent"));  // Defaults of the data are filled in.
}

TEST_CASE("mistakes name the file, the line and the nearest name") {
  CHECK_THROWS_WITH(Read(With("problems: 40", "problem: 40")), Contains("x.yaml:5") && Contains("problems"));
  CHECK_THROWS_WITH(Read(With("problems: 40", "problems: 1000000000")), Contains("from 1 to"));
  CHECK_THROWS_WITH(Read(With("problems: 40", "threads: 1000000000")), Contains("threads: expected an integer from 0"));
  CHECK_THROWS_WITH(Read(With("problems: 40", "problems: none")), Contains("x.yaml:5") && Contains("integer"));
  CHECK_THROWS_WITH(Read(With("name: second", "name: first")), Contains("stands twice"));
  CHECK_THROWS_WITH(Read(With("max_problems: 10", "conditions: [\"0.25\"]")), Contains("did you mean '0.2'"));
  CHECK_THROWS_WITH(Read(With("\"0.5\": 0.78", "\"0.5\": abc")), Contains("expected a number"));
  CHECK_THROWS_WITH(Read("name: x\ndata: {type: synthetic_line}\n"), Contains("list of methods"));
  CHECK_THROWS_WITH(Read("methods: [{name: a}]\n"), Contains("type"));
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
  CHECK_THROWS_WITH(Read(kSmallExperiment + std::string("compare: [[first, secund]]\n")),
                    Contains("x.yaml:17") && Contains("did you mean 'second'"));
  CHECK_THROWS_WITH(Read(kSmallExperiment + std::string("compare: [[first]]\n")), Contains("two methods"));
  CHECK_THROWS_WITH(Read(kSmallExperiment + std::string("scene_groups: [a, b]\n")), Contains("expected a map"));
}

TEST_CASE("rows of one series make a curve of budgets") {
  const ExperimentOptions experiment =
      Read(With("label: First}", "label: First, series: Ours}") + "figures: {bars: [first]}\n");
  REQUIRE(experiment.figures.budget.size() == 1);
  CHECK(experiment.figures.budget[0].label == "Ours");
  CHECK(experiment.figures.budget[0].methods == std::vector<std::string>{"first"});
  const std::string once = WriteExperiment(experiment);
  CHECK(Read(once).figures.budget.size() == 1);
  CHECK(WriteExperiment(Read(once)) == once);
}

TEST_CASE("strata are read, one or several, and checked") {
  const ExperimentOptions one = Read(kSmallExperiment + std::string("strata: {by: points, bins: [20, 40]}\n"));
  REQUIRE(one.strata.size() == 1);
  CHECK(one.strata[0].by == Quantity::kPoints);
  CHECK(one.strata[0].bins == std::vector<double>{20.0, 40.0});
  const std::string several = "strata:\n  - {bins: [0.5], rows: [first]}\n  - {by: scene}\n";
  const ExperimentOptions experiment = Read(kSmallExperiment + several);
  REQUIRE(experiment.strata.size() == 2);
  CHECK(experiment.strata[0].by == Quantity::kInlierShare);
  CHECK(experiment.strata[0].rows == std::vector<std::string>{"first"});
  const std::string once = WriteExperiment(experiment);
  CHECK(WriteExperiment(Read(once)) == once);
  const auto fails = [](const std::string& strata, const auto& message) {
    CHECK_THROWS_WITH(Read(kSmallExperiment + ("strata: " + strata + "\n")), message);
  };
  fails("{bin: [0.5]}", Contains("x.yaml:17") && Contains("'bins'"));
  fails("{by: inlier_shar, bins: [0.5]}", Contains("x.yaml:17") && Contains("inlier_share"));
  fails("{by: points}", Contains("x.yaml:17") && Contains("ascending edges"));
  fails("{bins: [0.5, 0.2]}", Contains("ascending edges"));
  fails("{bins: [0.2, 0.2]}", Contains("ascending edges"));
  fails("{by: scene, bins: [1]}", Contains("x.yaml:17") && Contains("bins"));
  fails("{bins: [0.5], rows: [secund]}", Contains("x.yaml:17") && Contains("did you mean 'second'"));
  fails("[{bins: [0.5]}, {bins: [0.6]}]", Contains("'inlier_share' stands twice"));
}

TEST_CASE("the distance of inliers in their share is for two views") {
  CHECK(Read("task: essential\ndata: {type: synthetic_two_view}\nmetric: {share_within_px: 1.5}\n"
             "methods: [{type: ransac}]\n")
            .share_within_px == 1.5);
  CHECK_THROWS_WITH(Read(kSmallExperiment + std::string("metric: {share_within_px: 1.5}\n")),
                    Contains("x.yaml:17") && Contains("share_within_px"));
}

TEST_CASE("every shipped table can be read, and no reference is left to be resolved") {
  for (const auto& entry : std::filesystem::directory_iterator(DIFFSAC_SOURCE_DIR "/configs/tables")) {
    if (entry.path().extension() != ".yaml") continue;
    INFO(entry.path().string());
    const ExperimentOptions experiment = ReadExperiment(ConfigFromFile(entry.path().string()));
    CHECK(experiment.name == entry.path().stem().string());
    CHECK_THAT(WriteExperiment(experiment), !Contains("${"));
  }
}

}  // namespace
}  // namespace diffsac
