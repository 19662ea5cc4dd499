#include "lab/eval/labelled_points.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <iterator>

#include "diffsac/core/status.h"
#include "lab/eval/colours.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/tables.h"

namespace diffsac {
namespace {

using Catch::Contains;
using namespace testing;

/// Finds the plane z = 1, or the line y = 1, whatever the points are.
struct AtOne : RobustEstimator {
  diffsac::Estimate DoRun(const NormalizedProblem& space, std::uint64_t) const override {
    const Problem& problem = space.problem();
    diffsac::Estimate estimate;
    estimate.status = Status::kOk;
    const Eigen::Index dimension = problem.points.cols();
    estimate.model = Eigen::VectorXd::Zero(dimension + 1);
    estimate.model[dimension - 1] = 1.0;
    estimate.model[dimension] = -1.0;
    estimate.inlier_threshold = problem.inlier_threshold;
    for (Eigen::Index i = 0; i < problem.points.rows(); ++i)
      estimate.inliers.push_back(std::abs(problem.points(i, dimension - 1) - 1.0) <= problem.inlier_threshold);
    return estimate;
  }
};

/// A run on this file.
ExperimentResults RunOn(const std::string& path, const std::string& task, const std::string& more_data = "",
                        const std::string& more = "") {
  const std::string yaml = "name: own\ntask: " + task + "\ndata: {type: point_sets, task: " + task + ", paths: ['" +
                           path + "'], inlier_threshold: 0.1, unit: m" + more_data +
                           "}\nmethods: [{name: first, type: at_one}, {name: 'se,cond', type: at_one}]\n" + more;
  return RunExperiment(ReadExperiment(ConfigFromYaml(yaml)),
                       {[](const Config&, Task) { return std::make_unique<AtOne>(); }, {}, nullptr});
}

std::string Cloud() {
  return "x,y,z\n0,0,1\n1,0,1.05\nnan,0,1\n0,1,2\n5e-7,1,0.95\n3,3,7\n2,2,1\n1,1,1\n4,1,1\n4,2,9\n";
}

std::vector<std::string> FilesIn(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(folder, code))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

TEST_CASE("every point of a text file goes out with its labels, those that were left out by their distance") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("scan.csv"), Cloud());
  const ExperimentResults all = RunOn(folder.File("scan.csv"), "plane");
  WriteLabels(all, folder.path());
  const std::string csv = ReadFile(folder.File("labels/scan.csv"));
  // The point that is not finite was left out, so that there is a column that says so.
  CHECK(csv.starts_with("x,y,z,first,\"se,cond\",used\n0,0,1,1,1,1\n1,0,1.05,1,1,1\nnan,0,1,0,0,0\n0,1,2,0,0,1\n"));
  CHECK_THAT(csv, Contains("\n5e-07,1,0.95,1,1,1\n"));

  const ExperimentResults some = RunOn(folder.File("scan.csv"), "plane", ", max_points: 4");
  WriteLabels(some, folder.path());
  const std::string subset = ReadFile(folder.File("labels/scan.csv"));
  std::string without;  // The labels are the same whether a point was drawn or not.
  for (std::size_t at = 0; at < subset.size(); at = subset.find('\n', at) + 1)
    without += subset.substr(at, subset.find_last_of(',', subset.find('\n', at)) - at) + "\n";
  std::string expected;
  for (std::size_t at = 0; at < csv.size(); at = csv.find('\n', at) + 1)
    expected += csv.substr(at, csv.find_last_of(',', csv.find('\n', at)) - at) + "\n";
  CHECK(without == expected);
  const auto& rows = some.cells[0].records[0].rows;
  REQUIRE(rows.size() == 4);
  CHECK(std::is_sorted(rows.begin(), rows.end()));
  CHECK(std::count(subset.begin(), subset.end(), '\n') == 11);
  for (std::int32_t i = 0, at = 0; i < 10; ++i) {
    at = static_cast<std::int32_t>(subset.find('\n', static_cast<std::size_t>(at)) + 1);
    const bool used = subset[subset.find('\n', static_cast<std::size_t>(at)) - 1] == '1';
    CHECK(used == (std::find(rows.begin(), rows.end(), i) != rows.end()));
  }
}

TEST_CASE("a cloud comes back as a cloud, with green inliers") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("scan.ply"),
                      std::string("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                  "property float z\nend_header\n0 0 1\n1 2 5\n2 1 1.05\n"));
  WriteLabels(RunOn(folder.File("scan.ply"), "plane"), folder.path());
  const std::string path = folder.File("labels/scan.ply"), bytes = ReadFile(path);
  CHECK_THAT(bytes, Contains("property int label_first\nproperty int label_se_cond\nend_header"));
  const PointSet read = ReadPlyPoints(path);
  REQUIRE(read.points.rows() == 3);
  CHECK(read.points.row(1) == Eigen::RowVector3d(1.0, 2.0, 5.0));
  constexpr std::size_t kRow = 3 * 8 + 3 + 2 * 4;
  const std::size_t begin = bytes.size() - 3 * kRow;
  const auto colour = [&](std::size_t i) {
    std::array<std::uint8_t, 3> parts{};
    for (std::size_t k = 0; k < 3; ++k) parts[k] = static_cast<std::uint8_t>(bytes[begin + i * kRow + 24 + k]);
    return parts;
  };
  CHECK(colour(0) == ColourParts(kInlierColour));
  CHECK(colour(1) == ColourParts(kOutlierColour));
  CHECK(colour(2) == ColourParts(kInlierColour));
  CHECK(bytes[begin + 27] == 1);
  CHECK(bytes[begin + kRow + 27] == 0);
}

TEST_CASE("several structures have a label and a colour each") {
  EstimateRecord record;
  record.status = Status::kOk;
  record.points = 2;
  record.rows = {1, 3};
  record.inlier_threshold = 0.2;
  record.instances = {Eigen::Vector3d(0, 1, -1), Eigen::Vector3d(1, 0, -2)};
  record.model = record.instances[0];
  record.assignment = {2, 0};
  PointMatrix points(6, 2);
  points << 0, 1, 2, 5, 2, 1.1, 0, 1, 9, 9, 1.9, 0.85;
  CHECK(LabelsOf(record, points, 0.1) == std::vector<std::int32_t>{1, 2, 2, 0, 0, 2});  // The drawn ones keep theirs.
  record.inlier_threshold = std::nan("");
  CHECK(LabelsOf(record, points, 0.01) == std::vector<std::int32_t>{1, 2, 2, 0, 0, 0});
  record.status = Status::kNoModel;
  CHECK(LabelsOf(record, points, 0.1) == std::vector<std::int32_t>(6, 0));

  const std::string ply = LabelsPly(PointMatrix::Ones(2, 3), {{"a", {2, 1}}}, 0, {});
  CHECK(static_cast<std::uint8_t>(ply[ply.size() - 31 - 7]) == ColourParts(InstanceColour(1))[0]);
  CHECK(static_cast<std::uint8_t>(ply[ply.size() - 7]) == ColourParts(InstanceColour(0))[0]);
}

TEST_CASE("labels are those of this run alone, of as many inputs as are asked for") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.File("in/a"));
  for (const char* name : {"in/1.txt", "in/2.csv", "in/a/1.txt"})
    WriteFileAtomically(folder.File(name), "0,1\n1,1\n2,5\n");
  const std::string both = folder.File("in") + "','" + folder.File("in/a");
  WriteLabels(RunOn(both, "line"), folder.path());
  CHECK(FilesIn(folder.File("labels")) == std::vector<std::string>{"1.txt.csv", "1.txt_2.csv", "2.csv"});
  CHECK(ReadFile(folder.File("labels/2.csv")) == "x,y,first,\"se,cond\"\n0,1,1,1\n1,1,1,1\n2,5,0,0\n");
  WriteLabels(RunOn(both, "line", "", "labels: 1\n"), folder.path());
  CHECK(FilesIn(folder.File("labels")) == std::vector<std::string>{"1.txt.csv"});
  WriteFileAtomically(folder.File("labels/notes.txt"), "mine");
  WriteLabels(RunOn(both, "line", "", "labels: 0\n"), folder.path());
  CHECK(FilesIn(folder.File("labels")) == std::vector<std::string>{"notes.txt"});
  WriteLabels(MadeUpResults(), folder.File("other"));
  CHECK_FALSE(std::filesystem::exists(folder.File("other")));
}

TEST_CASE("inputs that are gone when labels are written are a warning, a folder that cannot be written an error") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("scan.csv"), Cloud());
  const ExperimentResults results = RunOn(folder.File("scan.csv"), "plane");
  WriteFileAtomically(folder.File("file"), "");
  CHECK_THROWS_AS(WriteLabels(results, folder.File("file")), Error);
  std::filesystem::remove(folder.File("scan.csv"));
  CHECK_NOTHROW(WriteLabels(results, folder.path()));
  CHECK_FALSE(std::filesystem::exists(folder.File("labels")));
}

TEST_CASE("the models of own points are the last table, with their unit") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("scan.csv"), Cloud());
  const ExperimentResults results = RunOn(folder.File("scan.csv"), "plane");
  const Table table = MakeReport(results).tables.back();
  CHECK_THAT(table.heading, Contains("planes found") && Contains("d and noise in m"));
  REQUIRE(table.rows.size() == 2);
  CHECK(table.columns.size() == table.rows[0].cells.size());
  CHECK(std::vector<std::string>(table.rows[0].cells.begin(), table.rows[0].cells.begin() + 8) ==
        std::vector<std::string>{"first", "scan.csv", "0.000000", "0.000000", "1.000000", "-1", "6", "9"});
  CHECK_THAT(ProblemsCsv(results), Contains(",0 0 1 -1,"));

  ExperimentResults failed = results;
  failed.cells[0].records[0] = {};
  failed.cells[0].records[0].id = "scan.csv";
  failed.cells[0].records[0].status = Status::kDegenerate;
  failed.cells[1].records[0].instances = {Eigen::Vector4d(0, 0, 1, -1), Eigen::Vector4d(1, 0, 0, 2e12)};
  failed.cells[1].records[0].assignment = {1, 1, 2, 0, 0, 2, 2, 0, 0};
  const Table several = ModelTable(failed);
  REQUIRE(several.rows.size() == 3);
  CHECK(several.rows[0].cells[1] == "scan.csv (no model: degenerate)");
  CHECK(several.rows[2].cells[2] == "2");
  CHECK(several.rows[2].cells[7] == "3");
  CHECK(ModelTable(MadeUpResults()).rows.empty());
}

TEST_CASE("a plane far from the origin is printed with digits enough for its own points") {
  ExperimentResults results;
  results.experiment.task = Task::kPlane;
  results.experiment.methods.resize(1);
  results.experiment.conditions.resize(1);
  results.experiment.conditions[0].data = ConfigFromYaml("{type: point_sets}");
  const auto misses = [&](double far, double noise) {
    const Eigen::Vector3d normal = Eigen::Vector3d(-0.583283781, 0.23611226, -0.777194333).normalized();
    const Eigen::Vector3d point(0.9 * far, far, 0.01 * far);
    ProblemRecord record;
    record.status = Status::kOk;
    record.model = Eigen::Vector4d(normal[0], normal[1], normal[2], -normal.dot(point));
    record.sigma = noise;
    record.largest_coordinate = far;
    Cell cell;
    cell.records = {record};
    results.cells = {cell};
    const std::vector<std::string> cells = ModelTable(results).rows.at(0).cells;
    double distance = std::stod(cells[5]);
    for (int d = 0; d < 3; ++d) distance += std::stod(cells[2 + d]) * point[d];
    return std::abs(distance) > 0.15 * noise;
  };
  for (const double far : {1e-3, 1.0, 1e3, 5e6, 6.4e6, 1.7e9})
    for (const double noise : {1e-2, 1e-4}) CHECK_FALSE(misses(far, noise * std::min(far, 1.0)));
}

}  // namespace diffsac
