// The file of what was estimated: its columns, and its examples.

#include "lab/eval/estimates.h"

#include <H5Cpp.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "diffsac/geometry/pose.h"
#include "geometry/two_view_problems.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/kept_examples.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

using testing::MadeUpResults;

Numbers Read(const std::string& folder, const std::string& name) {
  return ReadNumbers(OpenHdf5(folder + "/estimates.h5").openDataSet(name), name);
}

nlohmann::json Examples(const std::string& folder) {
  const H5::DataSet data = OpenHdf5(folder + "/estimates.h5").openDataSet("examples/json");
  std::string text(static_cast<std::size_t>(data.getSpace().getSimpleExtentNpoints()), '\0');
  data.read(text.data(), H5::PredType::NATIVE_UINT8);
  return nlohmann::json::parse(text);
}

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

ExperimentResults RunOf(const std::string& yaml) {
  return RunExperiment(ReadExperiment(ConfigFromYaml(yaml)),
                       {[](const Config&, Task) { return std::make_unique<AtOne>(); }, {}, nullptr});
}

}  // namespace

TEST_CASE("estimates are columns of their records") {
  const TemporaryFolder folder;
  ExperimentResults results = MadeUpResults();
  results.experiment.methods[1].name = "net/work";
  std::vector<ProblemRecord>& records = results.cells[1].records;
  records[0].model = Eigen::Vector3d(1, 2, 3);
  records[0].pose = RigidMotion{Eigen::Matrix3d::Identity(), {4, 5, 6}};
  records[0].pose_covariance = 2.0 * Eigen::MatrixXd::Identity(6, 6);
  records[0].inlier_rows = {0, 2};
  records[1].inlier_rows = {5};
  records[2].ambiguous_pose = RigidMotion{Eigen::Matrix3d::Identity(), {3, 2, 1}};
  records[2].focal = FocalEstimate{{700, 701}, {650, 660}, {720, 730}};
  records[3].instances = {Eigen::Vector3d(1, 0, 2), Eigen::Vector3d(0, 1, 3)};
  records[3].assignment = {1, 0, 2};
  records[3].instance_values = {0.9, 0.7};
  WriteEstimates(results, folder.path());
  const std::string group = "net_work/0.2/";
  const auto values = [&](const std::string& name) { return Read(folder.path(), group + name).values; };
  CHECK(values("index") == std::vector<double>{0, 1, 2, 3});
  CHECK(Read(folder.path(), group + "model").shape == std::vector<hsize_t>{4, 3});
  CHECK(values("model")[2] == 3.0);
  CHECK(std::isnan(values("model")[3]));
  CHECK(values("pose")[7] == 5.0);
  CHECK(values("pose_covariance")[7] == 2.0);
  CHECK(values("inliers") == std::vector<double>{0, 2, 5});
  CHECK(values("inliers_end") == std::vector<double>{2, 3, 3, 3});
  CHECK(values("ambiguous_pose")[2 * 12 + 3] == 3.0);
  CHECK(values("focal")[2 * 6] == 700.0);
  CHECK(Read(folder.path(), group + "structures").shape == std::vector<hsize_t>{2, 3});
  CHECK(values("structures_end") == std::vector<double>{0, 0, 0, 2});
  CHECK(values("structure_values") == std::vector<double>{0.9, 0.7});
  CHECK(values("labels") == std::vector<double>{1, 0, 2});
  const H5::H5File file = OpenHdf5(folder.File("estimates.h5"));
  const H5::Attribute method = file.openGroup("net_work").openGroup("0.2").openAttribute("method");
  std::string name;
  method.read(method.getStrType(), name);
  CHECK(name == "net/work");
  CHECK_FALSE(file.nameExists("first/0.2/structures"));
  CHECK_FALSE(file.nameExists("first/0.2/focal"));
  CHECK_FALSE(file.nameExists("examples"));
  results.experiment.estimates = false;
  WriteEstimates(results, folder.path());
  CHECK_FALSE(std::filesystem::exists(folder.File("estimates.h5")));
}

TEST_CASE("without estimates the examples keep theirs") {
  const TemporaryFolder folder;
  const ExperimentResults results = RunOf(
      "{name: few, problems: 6, examples: 2, estimates: false, methods: [{type: at_one}],"
      " data: {type: synthetic_line, num_points: 30, split: test}}");
  CHECK(results.cells[0].records[1].model.size() == 3);
  CHECK(results.cells[0].records[2].model.size() == 0);
  WriteEstimates(results, folder.path());
  CHECK(Read(folder.path(), "at_one/all/index").values == std::vector<double>{0, 1});
  const nlohmann::json json = Examples(folder.path());
  REQUIRE(json["examples"].size() == 2);
  CHECK(json["examples"][1]["name"] == results.cells[0].records[1].id);
  CHECK(json["examples"][1]["true_model"].size() == 3);
  CHECK(Read(folder.path(), "examples/points-1").shape == std::vector<hsize_t>{30, 2});
  CHECK(Read(folder.path(), "examples/inliers-1").values.size() == 30);
}

TEST_CASE("own points are kept as they were read") {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.File("scan.csv"), "x,y,z\n0,0,1\n1,0,1.05\nnan,0,1\n0,1,2\n3,3,7\n2,2,1\n");
  const ExperimentResults results =
      RunOf("{name: own, task: plane, methods: [{type: at_one}], data: {type: point_sets, task: plane, paths: ['" +
            folder.File("scan.csv") + "'], inlier_threshold: 0.1}}");
  WriteEstimates(results, folder.path());
  const nlohmann::json json = Examples(folder.path());
  CHECK(json["examples"][0]["path"] == folder.File("scan.csv"));
  CHECK(Read(folder.path(), "examples/points-0").shape == std::vector<hsize_t>{5, 3});
  CHECK(Read(folder.path(), "examples/source-0").shape == std::vector<hsize_t>{6, 3});
  CHECK(Read(folder.path(), "at_one/all/rows").values == std::vector<double>{0, 1, 3, 4, 5});
}

TEST_CASE("a condition keeps one trace of its first problem") {
  ExperimentOptions experiment = testing::SmallExperiment();
  RunInputs inputs = testing::TwoPointInputs();
  inputs.trace = [](const RobustEstimator&, const Problem& problem, std::uint64_t) {
    return ConfidenceTrace{{1.0, 0.0}, {std::vector<float>(problem.points.rows(), 0.5f)}};
  };
  const ExperimentResults results = RunExperiment(experiment, inputs);
  REQUIRE(results.traces.size() == 2);
  CHECK(results.traces[1].condition == 1);
  const TemporaryFolder folder;
  WriteEstimates(results, folder.path());
  const nlohmann::json traces = Examples(folder.path())["traces"];
  CHECK(traces[1]["example"] == 40);
  CHECK(traces[1]["method"] == "first");
  CHECK(traces[1]["confidence"][0].size() == 30);
}

TEST_CASE("examples of two views are spread over the data") {
  ExperimentOptions experiment = testing::SmallExperiment();
  experiment.examples = 3;
  CHECK(ExamplePositions(experiment, 10) == std::vector<std::size_t>{0, 1, 2});
  experiment.task = Task::kFundamental;
  CHECK(ExamplePositions(experiment, 10) == std::vector<std::size_t>{0, 3, 6});
  CHECK(ExamplePositions(experiment, 2) == std::vector<std::size_t>{0, 1});
}

TEST_CASE("names of images stand in the example or its id") {
  Example example;
  example.id = "scene/a-b";
  CHECK(ImageNames(example) == std::pair<std::string, std::string>{"a", "b"});
  example.image1 = "x-1";
  example.image2 = "y";
  CHECK(ImageNames(example) == std::pair<std::string, std::string>{"x-1", "y"});
  CHECK(ImageNames(Example()) == std::pair<std::string, std::string>{});
}

TEST_CASE("a record has the pose of its model where there is one") {
  Rng rng(3);
  const testing::TwoViewProblem views = testing::RandomProblem(40, rng);
  Example example;
  example.id = "a-b";
  example.problem.task = Task::kEssential;
  example.problem.points = views.pixels;
  example.problem.cameras = CameraPair{views.k1, views.k2};
  Estimate estimate;
  estimate.status = Status::kOk;
  estimate.model = views.essential;
  estimate.inliers.assign(40, 1);
  estimate.inliers[3] = 0;
  estimate.stats.iterations = 77;
  const auto check_pose = [&](const EstimateRecord& record) {
    REQUIRE(record.pose);
    CHECK(RotationAngleDegrees(record.pose->rotation, views.pose.rotation) < 1e-6);
    CHECK(DirectionAngleDegrees(record.pose->translation, views.pose.translation) < 1e-6);
  };
  EstimateRecord record = RecordOf(example, estimate);
  CHECK(record.inlier_rows.size() == 39);
  CHECK(record.inlier_rows[3] == 4);
  check_pose(record);
  example.problem.task = Task::kFundamental;
  estimate.model = views.fundamental;
  check_pose(RecordOf(example, estimate));
  example.problem.cameras.reset();
  CHECK_FALSE(RecordOf(example, estimate).pose);
  estimate.status = Status::kNoModel;
  record = RecordOf(example, estimate);
  CHECK(record.model.size() == 0);
  CHECK(record.points == 40);
  CHECK(record.draws == 77);

  example.problem.task = Task::kAbsolutePose;
  estimate.status = Status::kOk;
  estimate.model = PoseOf(Eigen::Matrix3d::Identity(), Eigen::Vector3d(1, 2, 3));
  CHECK(RecordOf(example, estimate).pose->translation == Eigen::Vector3d(1, 2, 3));
  example.problem.task = Task::kLine;
  estimate.model = Eigen::Vector3d(1, 0, 2);
  CHECK_FALSE(RecordOf(example, estimate).pose);
}

}  // namespace diffsac
