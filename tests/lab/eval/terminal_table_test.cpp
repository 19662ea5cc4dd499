#include "lab/eval/terminal_table.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "lab/eval/eval_fixtures.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

std::string Printed(const ExperimentResults& results) {
  std::ostringstream out;
  PrintTable(results, out);
  return out.str();
}

/// One plane found in points of this extent.
ExperimentResults OwnPlane() {
  ExperimentResults results;
  results.experiment.task = Task::kPlane;
  results.experiment.methods.resize(1);
  results.experiment.methods[0].label = "one";
  results.experiment.conditions.resize(1);
  results.experiment.conditions[0].data = ConfigFromYaml("{type: point_sets, unit: m}");
  ProblemRecord record;
  record.id = "scan.csv";
  record.status = Status::kOk;
  record.model = Eigen::Vector4d(0, 0, 1, -1);
  record.inlier_rows = {0, 1, 2};
  record.points = 9;
  results.cells = {{0, 0, {record}}};
  return results;
}

std::vector<std::string> LastWords(const std::string& text) {
  std::istringstream last(text.substr(text.rfind('\n', text.size() - 2)));
  std::vector<std::string> words;
  for (std::string word; last >> word;) words.push_back(word);
  return words;
}

}  // namespace

TEST_CASE("the table has accuracy and median and time") {
  const std::string text = Printed(MadeUpResults());
  CHECK_THAT(text, Contains("small: mAA@0.5deg, median error in degrees, milliseconds; 4 problems, seed 3\n"));
  // Errors of .045, .09, .135, .18 within .5: (1 + .9 + .8 + .7) / 4; twice these: (.9 + .7 + .5 + .3) / 4.
  CHECK_THAT(text, Contains("First   0.850 0.113    0.5  0.600 0.225    0.5\n"));
}

TEST_CASE("without truth there are inliers and of structures recall") {
  ExperimentResults results = MadeUpResults();
  for (Cell& cell : results.cells)
    for (ProblemRecord& record : cell.records) record.error.angle_deg = std::nan("");
  CHECK_THAT(Printed(results), Contains("median inliers (no ground truth)") && Contains("First   20    0.5"));
  CHECK_THAT(Printed(MadeUpInstances()), Contains("recall of structures") && Contains("Second  0.500    0.5  0.250"));
}

TEST_CASE("scenes weigh the same and many conditions stand below") {
  ExperimentResults results = MadeUpPoses();
  CHECK_THAT(Printed(results), Contains("First   0.750"));
  results.experiment.conditions.resize(7, results.experiment.conditions[0]);
  results.experiment.conditions[6].label = "last";
  CHECK_THAT(Printed(results), Contains("\nmethod  all  last\n"));
}

TEST_CASE("models of own points are told with unit") {
  ExperimentResults results = OwnPlane();
  CHECK_THAT(Printed(results), Contains("planes found: n · x + d = 0, |n| = 1; d and noise in m\n"));
  const auto words = LastWords(Printed(results));
  REQUIRE(words.size() == 9);
  CHECK(std::vector<std::string>(words.begin() + 1, words.end()) ==
        std::vector<std::string>{"scan.csv", "0.000000", "0.000000", "1.000000", "-1", "3", "9", "-"});
  results.cells[0].records[0] = {};
  results.cells[0].records[0].status = Status::kDegenerate;
  CHECK_THAT(Printed(results), Contains("(no model: degenerate)"));
  CHECK_THAT(Printed(MadeUpResults()), !Contains("found"));
}

TEST_CASE("a far plane is printed with digits enough") {
  for (const double far : {1e-3, 1.0, 1e3, 5e6, 6.4e6, 1.7e9})
    for (const double noise : {1e-2, 1e-4}) {
      ExperimentResults results = OwnPlane();
      ProblemRecord& record = results.cells[0].records[0];
      const Eigen::Vector3d normal = Eigen::Vector3d(-0.583283781, 0.23611226, -0.777194333).normalized();
      const Eigen::Vector3d point(0.9 * far, far, 0.01 * far);
      record.model = Eigen::Vector4d(normal[0], normal[1], normal[2], -normal.dot(point));
      record.sigma = noise * std::min(far, 1.0);
      record.largest_coordinate = far;
      const auto words = LastWords(Printed(results));
      double distance = std::stod(words[5]);
      for (int d = 0; d < 3; ++d) distance += std::stod(words[static_cast<std::size_t>(2 + d)]) * point[d];
      CHECK(std::abs(distance) <= 0.15 * record.sigma);
    }
}

}  // namespace diffsac
