#include "lab/eval/selection.h"

#include <catch2/catch.hpp>

#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;
using testing::SmallExperiment;

ExperimentOptions Read(const std::string& text) { return ReadExperiment(ConfigFromYaml(text, "x.yaml")); }

TEST_CASE("rows are selected by name, in the experiment's order") {
  ExperimentOptions experiment = SmallExperiment();
  SelectEstimators({"oracle", "first"}, &experiment);
  REQUIRE(experiment.methods.size() == 2);
  CHECK(experiment.methods[0].name == "first");
  CHECK_THROWS_WITH(SelectEstimators({"orcale"}, &experiment), Contains("--methods") && Contains("'oracle'"));
}

const char* kRowWithoutNetwork = R"(
name: networks
data: {type: synthetic_line}
methods:
  - {name: learned, type: diffsac, label: Learned, checkpoint: there/is/no.safetensors}
  - {name: other, type: ransac}
)";

TEST_CASE("a row without its checkpoint is left out, and named") {
  ExperimentOptions experiment = Read(kRowWithoutNetwork + std::string("missing: leave_out\n"));
  CHECK(RowFiles(experiment) == std::vector<std::string>{"there/is/no.safetensors"});
  ExperimentOptions given = experiment;
  CHECK(LeaveOutMissing(true, &given));
  CHECK(given.methods.size() == 2);
  REQUIRE(LeaveOutMissing(false, &experiment));
  REQUIRE(experiment.methods.size() == 1);
  REQUIRE(experiment.left_out.size() == 1);
  CHECK(experiment.left_out[0] == "Learned (needs there/is/no.safetensors)");
  // Otherwise it stays, and the run fails with the missing file.
  experiment = Read(kRowWithoutNetwork);
  CHECK(LeaveOutMissing(false, &experiment));
  CHECK(experiment.methods.size() == 2);
  CHECK(experiment.left_out.empty());
  experiment = Read(kRowWithoutNetwork + std::string("missing: leave_out\n"));
  SelectEstimators({"learned"}, &experiment);
  CHECK_FALSE(LeaveOutMissing(false, &experiment));
}

TEST_CASE("a condition without its data is left out with the rows for it alone, and named") {
  const char* text = R"(
name: descriptors
task: fundamental
missing: leave_out
data: {type: synthetic_two_view, task: fundamental}
conditions:
  - {name: here}
  - {name: absent, label: Absent, data: {type: correspondences, paths: [no/such/pairs]}}
methods:
  - {name: both, type: ransac}
  - {name: here_alone, type: ransac, conditions: [here]}
  - {name: absent_alone, type: ransac, label: Lost, conditions: [absent]}
)";
  ExperimentOptions experiment = Read(text);
  CHECK(DataPaths(experiment) == std::vector<std::string>{"no/such/pairs"});
  REQUIRE(LeaveOutMissing(false, &experiment));
  REQUIRE(experiment.conditions.size() == 1);
  REQUIRE(experiment.methods.size() == 2);
  CHECK(experiment.methods[1].name == "here_alone");
  REQUIRE(experiment.left_out.size() == 2);
  CHECK_THAT(experiment.left_out[0], Contains("Absent") && Contains("no/such/pairs"));
  CHECK_THAT(experiment.left_out[1], Contains("Lost"));
  CHECK_NOTHROW(Read(WriteExperiment(experiment)));  // nothing refers to what is left out

  experiment = Read(text);
  experiment.conditions.erase(experiment.conditions.begin());
  CHECK_FALSE(LeaveOutMissing(false, &experiment));
}

TEST_CASE("of several scenes those that are there are used, and the others named once") {
  const TemporaryFolder folder;
  const ExperimentOptions whole =
      Read("task: plane\nmissing: leave_out\ndata: {type: point_sets, task: plane, inlier_threshold: 1, paths: [" +
           folder.path() + ", no/scan]}\nconditions: [{name: a}, {name: b}]\nmethods: [{type: ransac}]\n");
  ExperimentOptions experiment = whole;
  REQUIRE(LeaveOutMissing(false, &experiment));
  REQUIRE(experiment.conditions.size() == 2);
  CHECK(experiment.conditions[1].data.Sequence("paths").size() == 1);
  CHECK(experiment.left_out == std::vector<std::string>{"no/scan (not there)"});
  CHECK(whole.conditions[0].data.Sequence("paths").size() == 2);
}

}  // namespace
}  // namespace diffsac
