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
  CHECK(experiment.RowOf("second") == 1);
  CHECK(experiment.RowOf("third") == 3);
}

TEST_CASE("captions are kept and make no other experiment") {
  const ExperimentOptions other =
      Read(With("label: First", "label: Best") + "report: {title: Mine, any: [{thing: 1}]}\n");
  CHECK_THAT(WriteExperiment(other), Contains("title: Mine") && Contains("thing: 1"));
  CHECK(WriteExperiment(Read(WriteExperiment(other))) == WriteExperiment(other));
  CHECK(WriteMeasured(other) == WriteMeasured(SmallExperiment()));
  CHECK(WriteMeasured(Read(With("problems: 40", "problems: 41"))) != WriteMeasured(SmallExperiment()));
}

TEST_CASE("the written experiment reads back to the same") {
  const std::string once = WriteExperiment(SmallExperiment());
  CHECK(WriteExperiment(Read(once)) == once);
  CHECK_THAT(once, Contains("model_sampling"));  // Defaults of the data are filled in.
}

TEST_CASE("mistakes name the file, the line and the nearest name") {
  CHECK_THROWS_WITH(Read(With("problems: 40", "problem: 40")), Contains("x.yaml:") && Contains("problems"));
  CHECK_THROWS_WITH(Read(With("problems: 40", "problems: 1000000000")), Contains("from 1 to"));
  CHECK_THROWS_WITH(Read(With("problems: 40", "threads: 1000000000")), Contains("threads: expected an integer from 0"));
  CHECK_THROWS_WITH(Read(With("problems: 40", "problems: none")), Contains("x.yaml:") && Contains("integer"));
  CHECK_THROWS_WITH(Read(With("name: second", "name: first")), Contains("stands twice"));
  CHECK_THROWS_WITH(Read(With("max_problems: 10", "conditions: [\"0.25\"]")), Contains("did you mean '0.2'"));
  CHECK_THROWS_WITH(Read("name: x\ndata: {type: synthetic_line}\n"), Contains("list of methods"));
  CHECK_THROWS_WITH(Read("methods: [{name: a}]\n"), Contains("type"));
}

TEST_CASE("the distance of inliers in their share is for two views") {
  CHECK(Read("task: essential\ndata: {type: synthetic_two_view}\nmetric: {share_within_px: 1.5}\n"
             "methods: [{type: ransac}]\n")
            .share_within_px == 1.5);
  CHECK_THROWS_WITH(Read(kSmallExperiment + std::string("metric: {share_within_px: 1.5}\n")),
                    Contains("x.yaml:") && Contains("share_within_px"));
}

TEST_CASE("every shipped table can be read") {
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
