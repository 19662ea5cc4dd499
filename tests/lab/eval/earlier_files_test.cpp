// version_0_1/ holds a small file of each format as version 0.1.0 wrote it (docs/versions.md promises to read them): a
// network trained for 30 steps, its configuration YAML as in the first of them; estimates, problems.csv and
// results.json of three lines; the correspondences of a pair. They are never written again: a later version gets a
// folder of its own.

#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>
#include <sstream>

#include "diffsac/core/former_names.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/eval/estimates.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/files/correspondence_files.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

const std::string kFolder = DIFFSAC_SOURCE_DIR "/tests/lab/eval/version_0_1/";

// The words of a file's first line.
std::vector<std::string> Columns(const std::string& path) {
  std::istringstream file(ReadFile(path));
  std::string line, column;
  std::getline(file, line);
  std::istringstream columns(line);
  std::vector<std::string> names;
  while (std::getline(columns, column, ',')) names.push_back(column);
  return names;
}

}  // namespace

TEST_CASE("estimates of version 0.1.0 are read, and its network gives them again") {
  const EstimateFile file = ReadEstimates(kFolder + "estimates.h5");
  CHECK(file.experiment == "earlier");
  CHECK(file.task == "line");
  REQUIRE(file.groups.size() == 2);
  const auto data =
      MakeDataset(ConfigFromYaml("{type: synthetic_line, num_points: 30, split: test, outlier_ratio: 0.5}"), 3);
  const auto network =
      MakeEstimator(ConfigFromYaml("{type: diffsac, checkpoint: '" + kFolder + "model.safetensors'}"), Task::kLine, {});
  for (const EstimateGroup& group : file.groups) {
    CAPTURE(group.method);
    CHECK(group.condition == "0.5");
    REQUIRE(group.records.size() == 3);
    for (std::size_t k = 0; k < group.records.size(); ++k) {
      const EstimateRecord& record = group.records[k];
      const Example example = data->Get(k);
      CHECK(record.status == Status::kOk);
      CHECK(record.points == 30);
      CHECK(record.model.size() == 3);
      CHECK(!record.inlier_rows.empty());
      if (group.method != "diffsac") continue;
      const Estimate again = network->Run(example.problem, ProblemSeed(3, example));
      CHECK((again.model - record.model).norm() < 1e-5 * record.model.norm());
      CHECK(again.inliers.size() == 30);
    }
  }
}

TEST_CASE("correspondence files of version 0.1.0 are read") {
  const CorrespondenceScene scene(kFolder + "views");
  REQUIRE(scene.size() == 1);
  const Example pair = scene.Read(0);
  CHECK(pair.problem.points.rows() == 28);
  CHECK(pair.problem.snn_ratio.size() == 28);
  CHECK(pair.problem.scale_rotation_changes.rows() == 28);
  CHECK(pair.problem.size1.width == 160);
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = 9.0;
  REQUIRE(pair.truth.homography);
  CHECK(pair.truth.homography->isApprox(shift));
}

TEST_CASE("tables of version 0.1.0 have no other columns") {
  const TemporaryFolder folder;
  const ExperimentResults results = testing::MadeUpResults();
  const Report report = MakeReport(results);
  WriteResults(report, folder.path());
  EndResults(report, folder.path());
  const auto now = Columns(folder / "problems.csv");
  for (const std::string& column : Columns(kFolder + "problems.csv")) {
    CAPTURE(column);
    CHECK(std::count(now.begin(), now.end(), column) + std::count(now.begin(), now.end(), CurrentName(column)) >= 1);
  }
  const auto before = nlohmann::json::parse(ReadFile(kFolder + "results.json"));
  const auto today = nlohmann::json::parse(ReadFile(folder / "results.json"));
  for (const auto& [key, value] : before.items()) {
    CAPTURE(key);
    CHECK(today.contains(key));
  }
}

}  // namespace diffsac
