#include "lab/eval/run_files.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>

#include "diffsac/core/status.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/factor_fixtures.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

TEST_CASE("results.csv is long, with each scene and their unweighted mean") {
  ExperimentResults results = MadeUpResults();
  results.cells.resize(1);
  results.cells[0].records[3].scene = "other";
  const std::string csv = ResultsCsv(MakeReport(results));
  CHECK_THAT(csv, Catch::StartsWith("experiment,dataset,scene,condition,method,metric,value\n"
                                    "small,synthetic_line,all,0.2,first,mAA@0.5deg,"));
  CHECK_THAT(csv, Contains("small,synthetic_line,other,0.2,first,median_deg,0.18\n"));
  CHECK_THAT(csv, Contains("small,synthetic_line,mean,0.2,first,median_deg,0.135\n"));  // (.1 + .2) / 2
  CHECK_THAT(csv, Contains("small,synthetic_line,mean,0.2,first,problems,4\n"));
  CHECK_THAT(csv, Contains("small,synthetic_line,mean,0.2,first,failures,0\n"));
}

TEST_CASE("problems.csv has a line for each problem and method") {
  ExperimentResults results = MadeUpResults();
  results.cells[0].records[0].id = "a,\"b\"";
  results.cells[0].records[1].error = {std::nan(""), std::nan(""), true};
  results.cells[0].records[1].status = Status::kDegenerate;
  results.cells[0].records[1].inlier_share = 0.25;
  results.cells[0].records[1].true_baseline = 12.5;
  const std::string csv = ProblemsCsv(results);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 6 * 4);
  CHECK_THAT(csv, Contains("\"a,\"\"b\"\"\",all,0.2,first,ok,0.045,0.1,,,,,20,20,0,0,0,0.5,30,0,0,,,,,,,,,,,,,,,,,\n"));
  CHECK_THAT(csv, Contains("p1,all,0.2,first,degenerate,,,,,,,20,20,0,0,0,0.5,30,1,0,,,,,,,,,,,,0.25,,12.5,,,\n"));
}

TEST_CASE("problems.csv has noise, pose and model where estimates are kept, with or without truth") {
  ExperimentResults results = MadeUpResults();
  Cell& cell = results.cells[0];
  cell.records[0].sigma = 0.25;
  cell.records[0].model = Eigen::Vector3d(1, 2, 3);
  cell.records[0].log10_nfa = 1.5;
  cell.records[1].pose = RigidMotion{Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal(), Eigen::Vector3d(0.6, 0.0, -0.8)};
  const std::string csv = ProblemsCsv(results);
  CHECK_THAT(csv, Contains("p0,all,0.2,first,ok,0.045,0.1,,,,,20,20,0,0,0,0.5,30,0,0,,0.25,,,,,,,,1 2 3,1.5,,,,,,\n"));
  CHECK_THAT(csv, Contains(",,0,1,0,0,0.6,0,-0.8,,,,,,,,\n"));
  const std::string header = csv.substr(0, csv.find('\n'));
  for (std::size_t at = 0; at < csv.size(); at = csv.find('\n', at) + 1) {
    const std::string line = csv.substr(at, csv.find('\n', at) - at);
    CHECK(std::count(line.begin(), line.end(), ',') == std::count(header.begin(), header.end(), ','));
  }
}

TEST_CASE("results.json has intervals and paired differences") {
  ExperimentResults results = MadeUpResults();
  results.experiment.reference = "first";
  const auto json = nlohmann::json::parse(ResultsJson(MakeReport(results)));
  CHECK(json["experiment"] == "small");
  CHECK_FALSE(json["partial"].get<bool>());
  REQUIRE(json["results"].size() == 6);
  const auto& second = json["results"][1];
  CHECK(second["method"] == "second");
  CHECK(second["metrics"]["mean"]["mAA@0.5deg"].get<double>() == Approx(0.45));
  CHECK(second["mAA@0.5deg_ci95"]["low"].get<double>() <= 0.45);
  CHECK(second["reference_minus_this"]["mean"].get<double>() == Approx(0.4));
  CHECK(json["results"][0]["reference_minus_this"].is_null());
  CHECK(json["paper"]["RANSAC"]["0.5"]["median_deg"].is_null());
  CHECK(ResultsJson(MakeReport(results)) == ResultsJson(MakeReport(results)));
}

TEST_CASE("problems.csv and results.json have more where several structures are judged") {
  const ExperimentResults results = MadeUpInstances();
  const std::string csv = ProblemsCsv(results);
  CHECK_THAT(csv.substr(0, csv.find('\n')),
             Catch::EndsWith(",tz,model,log10_nfa,inlier_share,true_rotation_deg,true_baseline,true_parallax_deg,"
                             "rotation_level,translation_level,"
                             "misclassified,recall,"
                             "one_structure_sets,structures_in_sets,structures,draws,structure_angles_deg"));
  CHECK_THAT(
      csv,
      Contains("p1,all,0.5,second,ok,0.48,0.1,,,,,20,20,0,0,0,0.5,30,0,0,,,,,,,,,,,,,,,,,,75,0.25,0.25,0.25,3,0,\n"));
  CHECK_THAT(ResultsCsv(MakeReport(results)),
             Contains(",mean,0.5,second,misclassification,65.625\n") && Contains(",mean,0.5,second,recall,0.25\n") &&
                 Contains(",first,misclassification_median,50\n") && Contains(",second,structures,3\n") &&
                 Contains(",second,structures_in_sets,0.25\n") && Contains(",first,draws,20\n"));
  const auto json = nlohmann::json::parse(ResultsJson(MakeReport(results)));
  CHECK(json["results"][1]["recall_ci95"]["low"].get<double>() == 0.5);
  CHECK(json["results"][1]["one_structure_sets_ci95"]["high"].get<double>() == 0.5);
  REQUIRE(json["differences"].size() == 4);
  CHECK(json["differences"][0]["metric"] == "recall");
  CHECK(json["differences"][2]["metric"] == "one_structure_sets");
  CHECK(json["differences"][2]["low"].get<double>() == 0.5);
  const ExperimentResults one = MadeUpResults();
  const std::string plain = ProblemsCsv(one) + ResultsCsv(MakeReport(one));
  for (const char* word : {"recall", "misclassif", "structure", "draws"}) CHECK_THAT(plain, !Contains(word));
}

TEST_CASE("several scenes are reported one by one, as their mean and over all pairs") {
  const ExperimentResults results = MadeUpPoses();
  const std::string csv = ResultsCsv(MakeReport(results));
  CHECK_THAT(
      csv, Contains(",a,all,first,mAA@10deg,1\n") && Contains(",b,all,first,mAA@10deg,0.5\n") &&
               Contains(",mean,all,first,mAA@10deg,0.75\n") && Contains(",all_pairs,all,first,mAA@10deg,0.625\n") &&
               Contains(",all_pairs,all,second,failures,1\n") && Contains(",all_pairs,all,second,mAA_R@10deg,0.875\n"));
  for (const char* metric : {"mAA_t@10deg", "AUC@5deg", "AUC@10deg", "AUC@20deg", "median_R_deg", "median_t_deg"})
    CHECK_THAT(csv, Contains(std::string(",mean,all,second,") + metric + ","));
  // One scene is all pairs already.
  const ExperimentResults one_scene = MadeUpResults();
  CHECK_THAT(ResultsCsv(MakeReport(one_scene)), !Contains("all_pairs"));
}

TEST_CASE("comparisons have an interval around the difference of the scenes' means") {
  const ExperimentResults results = MadeUpPoses();
  const auto json = nlohmann::json::parse(ResultsJson(MakeReport(results)));
  REQUIRE(json["differences"].size() == 1);
  const auto& difference = json["differences"][0];
  CHECK(difference["a"] == "first");
  CHECK(difference["b"] == "second");
  CHECK(difference["condition"] == "all");
  CHECK(difference["metric"] == "mAA@10deg");
  CHECK(difference["mean"].get<double>() == Approx(0.475));
  // Scene a always differs by .7, scene b by .2 for each pair but the last, .5: (.7 + .2) / 2 is the least.
  CHECK(difference["low"].get<double>() == Approx(0.45));
  CHECK(difference["high"].get<double>() > 0.475);
  CHECK(difference["high"].get<double>() <= 0.6);
  CHECK(DifferenceOf(results, 0, 1, 0)->mean == Approx(-0.475));
  CHECK_FALSE(DifferenceOf(results, 0, 0, 0));
}

TEST_CASE("results.json has effects, strata and what stands beside the paper as numbers") {
  ExperimentResults results =
      MadeUpFactors([](std::size_t, std::size_t m, int i) { return m >= 3 || i >= 6 ? 0.0 : 90.0; });
  results.cells[11].records.clear();  // good_many on the second condition
  const auto json = nlohmann::json::parse(ResultsJson(MakeReport(results)));
  CHECK(json["compare"][0] == nlohmann::json{"good_many", "plain_few"});
  const auto& good = json["effects"][0]["levels"][1];
  CHECK(good["accuracy"][0]["mean"].get<double>() == Approx(0.625));
  CHECK(good["milliseconds"][0]["mean"].get<double>() == Approx(10.0));
  CHECK(good["combinations"] == nlohmann::json{3, 2});
  const auto& strata = json["strata"][0];
  CHECK(strata["rows"].size() == 6);
  CHECK(strata["unknown"] == nlohmann::json{0, 0});
  CHECK(strata["bins"][0]["accuracies"][3]["mean"].get<double>() == 1.0);
  CHECK(strata["bins"][0]["accuracies"][3]["low"].is_null());
  CHECK(strata["bins"][0]["differences"][0][0]["mean"].get<double>() == 1.0);
  CHECK(strata["bins"][0]["differences"][0][1].is_null());
  CHECK(strata["bins"][2]["effects"][0]["levels"][1]["accuracy"][0]["high"].get<double>() == 0.0);
  CHECK(json["conditions"][1]["rows_share_problems"].get<bool>());
  ExperimentResults poses = MadeUpPoses();
  PaperRow paper;
  paper.ours = "second";
  paper.values["all"].rotation = 0.5;
  paper.values["all"].translation = 0.25;
  poses.experiment.paper.push_back({"DiffSAC", paper});
  const auto beside = nlohmann::json::parse(ResultsJson(MakeReport(poses)))["beside_paper"];
  REQUIRE(beside.size() == 2);
  CHECK(beside[0]["metric"] == "mAA of R");
  // 7.5 degrees of translation: three of ten thresholds, in the mean over scenes one in six of scene b has none.
  CHECK(beside[1]["ours"]["mean"].get<double>() == Approx(0.275));
  CHECK(beside[1]["problems"] == 8);
}

TEST_CASE("a row of the paper that names no row of ours is refused") {
  std::string text = testing::kSmallExperiment;
  text.replace(text.find("RANSAC: {"), 9, "RANSAC: {ours: frist, ");
  CHECK_THROWS_WITH(ReadExperiment(ConfigFromYaml(text, "x.yaml")), Contains("first"));
}

TEST_CASE("rows with different numbers of problems are compared on the common ones") {
  ExperimentResults results = MadeUpResults();
  results.experiment.reference = "first";
  results.cells[1].records.erase(results.cells[1].records.begin());
  CHECK_NOTHROW(ResultsJson(MakeReport(results)));
}

TEST_CASE("all files are written, and a folder that is not there is an error") {
  const TemporaryFolder folder;
  const ExperimentResults results = MadeUpResults();
  WriteResults(MakeReport(results), folder.path());
  CHECK_FALSE(std::filesystem::exists(folder.File("results.json")));  // Comes last.
  EndResults(MakeReport(results), folder.path());
  for (const char* name : {"results.json", "results.csv", "problems.csv", "table.md"})
    CHECK_FALSE(ReadFile(folder.File(name)).empty());
  CHECK_THROWS_AS(WriteResults(MakeReport(results), folder.File("absent")), Error);
  BeginResults(folder.path());
  CHECK_FALSE(std::filesystem::exists(folder.File("results.json")));
  CHECK_NOTHROW(BeginResults(folder.File("absent")));
}

TEST_CASE("a run ends with where its results are, and only those that are there") {
  const TemporaryFolder folder;
  CHECK(ResultsText(folder.path()) == "results are in " + folder.path());
  WriteFileAtomically(folder.File("report.html"), "");
  WriteFileAtomically(folder.File("problems.csv"), "");
  CHECK(ResultsText(folder.path()) ==
        "results are in " + folder.path() + ": report.html (open it in a browser), problems.csv");
}

}  // namespace
}  // namespace diffsac
