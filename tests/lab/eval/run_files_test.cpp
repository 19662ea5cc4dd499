#include "lab/eval/run_files.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>

#include "diffsac/core/status.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

TEST_CASE("problems.csv has a line for each problem and method") {
  ExperimentResults results = MadeUpResults();
  results.cells[0].records[0].id = "a,\"b\"";
  results.cells[0].records[1].error = {std::nan(""), std::nan(""), true};
  results.cells[0].records[1].status = Status::kDegenerate;
  results.cells[0].records[1].inlier_share = 0.25;
  results.cells[0].records[1].true_baseline = 12.5;
  const std::string csv = ProblemsCsv(results);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 6 * 4);
  CHECK_THAT(csv,
             Contains("0,\"a,\"\"b\"\"\",all,0.2,first,ok,0.045,0.1,,,,,20,20,0,0,0,0.5,30,0,0,,,,,,,,,,,,,,,,,,\n"));
  CHECK_THAT(csv, Contains("p1,all,0.2,first,degenerate,,,,,,,20,20,0,0,0,0.5,30,1,0,,,,,,,,,,,,0.25,,12.5,,,,\n"));
}

TEST_CASE("problems.csv has noise, pose and model where estimates are kept, with or without truth") {
  ExperimentResults results = MadeUpResults();
  Cell& cell = results.cells[0];
  cell.records[0].sigma = 0.25;
  cell.records[0].model = Eigen::Vector3d(1, 2, 3);
  cell.records[0].log10_nfa = 1.5;
  cell.records[1].pose = RigidMotion{Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal(), Eigen::Vector3d(0.6, 0.0, -0.8)};
  const std::string csv = ProblemsCsv(results);
  CHECK_THAT(csv, Contains("p0,all,0.2,first,ok,0.045,0.1,,,,,20,20,0,0,0,0.5,30,0,0,,0.25,,,,,,,,1 2 3,1.5,,,,,,,\n"));
  CHECK_THAT(csv, Contains(",,0,1,0,0,0.6,0,-0.8,,,,,,,,,\n"));
  const std::string header = csv.substr(0, csv.find('\n'));
  for (std::size_t at = 0; at < csv.size(); at = csv.find('\n', at) + 1) {
    const std::string line = csv.substr(at, csv.find('\n', at) - at);
    CHECK(std::count(line.begin(), line.end(), ',') == std::count(header.begin(), header.end(), ','));
  }
}

TEST_CASE("numbers have all their digits") {
  ExperimentResults results = MadeUpResults();
  results.cells[0].records[0].error.angle_deg = 0.1 + 0.2;
  results.cells[0].records[0].error.error_px = std::numeric_limits<double>::infinity();
  results.cells[0].records[0].log10_nfa = -std::numeric_limits<double>::infinity();
  CHECK_THAT(ProblemsCsv(results), Contains(",0.30000000000000004,0.1,,,inf,,") && Contains(",-inf,"));
}

TEST_CASE("several structures have columns of their own") {
  const std::string csv = ProblemsCsv(MadeUpInstances());
  CHECK_THAT(csv.substr(0, csv.find('\n')),
             Catch::EndsWith(",tz,model,log10_nfa,inlier_share,true_rotation_deg,true_baseline,true_parallax_deg,"
                             "rotation_level,translation_level,misclassified,recall,one_structure_sets,"
                             "structures_in_sets,structures,draws,structure_angles_deg,largest_coordinate"));
  CHECK_THAT(csv, Contains("p1,all,0.5,second,ok,0.48,0.1,,,,,20,20,0,0,0,0.5,30,0,0,,,,,,,,,,,,,,,,,,75,0.25,0.25,"
                           "0.25,3,0,,\n"));
  for (const char* word : {"recall", "misclassif", "structure", "draws"})
    CHECK_THAT(ProblemsCsv(MadeUpResults()), !Contains(word));
}

TEST_CASE("run.json says what was run and on what") {
  ExperimentResults results = MadeUpResults();
  results.experiment.report = ConfigFromYaml("{title: Small lines}");
  results.problems = {4, 4};
  results.shard = {2, 3};
  results.learned = {{1, {1234, 50, 100, "start"}}};
  results.experiment.left_out = {"Absent (needs no.safetensors)"};
  results.reliability = {{"First", 1, {{"all", {}}}}};
  results.reliability[0].scenes["all"][9] = {4.0, 3.6, 3.0};
  const std::string config = "# program: diffsac_eval\n# date: today\n\n" + WriteExperiment(results.experiment);
  const auto json = nlohmann::json::parse(RunJson(results, {"net", "cpu"}, config));
  CHECK(json["experiment"] == "small");
  CHECK(json["threshold_deg"] == 0.5);
  CHECK(json["partial"] == false);
  CHECK(json["shard"] == nlohmann::json{{"index", 2}, {"count", 3}});
  CHECK(json["setup"]["checkpoint"] == "net");
  CHECK(json["left_out"][0] == "Absent (needs no.safetensors)");
  CHECK(json["conditions"][1] == nlohmann::json{{"name", "0.5"}, {"label", "0.5"}, {"value", 0.5}, {"problems", 4}});
  CHECK(json["methods"][1]["max_problems"] == 10);
  CHECK(json["methods"][2]["competes"] == false);
  CHECK(json["learned"]["second"]["samples"] == 50);
  CHECK(json["facts"]["run"] == nlohmann::json{{"date", "today"}});
  CHECK(json["reliability"][0]["scenes"]["all"][9] == nlohmann::json{4.0, 3.6, 3.0});
  CHECK(json["configuration"]["seed"] == 3);
  CHECK(json["configuration"]["report"]["title"] == "Small lines");
}

TEST_CASE("files of a run and its captions") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  WriteFileAtomically(folder.File("config.yaml"), "# program: x\n\n" + WriteExperiment(results.experiment));
  WriteRun(results, {}, folder.path());
  for (const char* name : {"run.json", "problems.csv", "estimates.h5"})
    CHECK_FALSE(ReadFile(folder.File(name)).empty());
  CHECK_THROWS_AS(WriteRun(results, {}, folder.File("absent")), Error);
  results.experiment.report = ConfigFromYaml("{title: Other}");
  results.experiment.methods[0].label = "Renamed";
  UpdateCaptions(results.experiment, folder.path());
  const auto json = nlohmann::json::parse(ReadFile(folder.File("run.json")));
  CHECK(json["configuration"]["report"]["title"] == "Other");
  CHECK(json["methods"][0]["label"] == "Renamed");
  CHECK_THAT(ReadFile(folder.File("config.yaml")), Contains("# program: x\n\n") && Contains("Renamed"));
}

}  // namespace
}  // namespace diffsac
