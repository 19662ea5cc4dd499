#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <filesystem>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "diffsac/problem/tasks.h"
#include "geometry/segments.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"
#include "lab/files/segment_files.h"
#include "lab/train/train_request.h"

namespace diffsac {
namespace {

constexpr const char* kTiny = R"(
name: tiny
method: structure_chooser
task: vanishing_point
data: {type: vanishing_points, paths: [DATA], calibrated: true}
network: {width: 8, heads: 2, layers: 1, hidden: 8, pair_width: 4}
structure_chooser: {draws: 60}
train: {iterations: 6, batch_size: 4, warmup_iterations: 2, log_every: 3, validate_every: 6, checkpoint_every: 3}
validation: {problems: 4, outlier_ratios: [], threshold_deg: 10}
)";

/// Images of rooms, of which two directions show.
void WriteRooms(const std::string& folder) {
  std::vector<ImageSegments> images;
  for (int i = 0; i < 6; ++i) {
    const Rng rng = Rng(7).Fork("room", i);
    const Eigen::Matrix3d directions =
        Eigen::AngleAxisd(0.3 + 0.1 * i, Eigen::Vector3d(0.3, 1.0, 0.2).normalized()).toRotationMatrix();
    ImageSegments image{"room" + std::to_string(i), {}, {}, {}, {640, 480}};
    image.K = (Eigen::Matrix3d() << 320, 0, 320, 0, 320, 240, 0, 0, 1).finished();
    image.segments = testing::Stacked(testing::SegmentsTowards(directions.col(0), 30, 0.003, rng.Fork("first")),
                                      testing::SegmentsTowards(directions.col(1), 20, 0.003, rng.Fork("second")));
    for (Eigen::Index row = 0; row < image.segments.rows(); ++row)
      image.segments.row(row) = (320.0 * image.segments.row(row) + Eigen::RowVector4d(320, 240, 320, 240)).eval();
    for (int k = 0; k < 2; ++k) image.vanishing_points.push_back(*image.K * directions.col(k));
    images.push_back(image);
  }
  std::filesystem::create_directories(folder + "/rooms");
  WriteSegments(folder + "/rooms/segments.h5", images);
}

Config TinyConfig(const std::string& data) {
  std::string yaml = kTiny;
  yaml.replace(yaml.find("DATA"), 4, "'" + data + "'");
  return ConfigFromYaml(yaml, "tiny.yaml");
}

std::string Row(const std::string& checkpoint, const std::string& more = "") {
  return "{type: ransac, max_iterations: 200, instances: {search: chosen, most: 3, chooser: '" + checkpoint + "'" +
         more + "}}";
}

Estimate RunRow(const std::string& row, const Problem& problem) {
  return MakeEstimator(ConfigFromYaml(row), Task::kVanishingPoint, {})->Run(problem, 1);
}

}  // namespace

TEST_CASE("a chooser of vanishing points is trained, goes on where it was, and chooses for any sampler") {
  const TemporaryFolder folder;
  WriteRooms(folder.path());
  const std::string once = folder / "once", again = folder / "again";
  REQUIRE(Train(OneThread(TinyConfig(folder.path()), once), kNever) == TrainOutcome::kFinished);
  REQUIRE(Train(OneThread(TinyConfig(folder.path()), again), kNever) == TrainOutcome::kFinished);
  const std::string best = once + "/checkpoints/best.safetensors";
  CHECK(ReadFile(once + "/metrics.csv").find("loss_gain") != std::string::npos);

  const std::string data = "{type: vanishing_points, calibrated: true, paths: ['" + folder.path() + "']}";
  const Example example = MakeDataset(ConfigFromYaml(data), 1)->Get(2);
  const Estimate estimate = RunRow(Row(best), example.problem);
  REQUIRE(estimate.status == Status::kOk);
  CHECK(estimate.instances.size() == 3);
  CHECK(estimate.assignment.size() == 50);
  const Estimate same = RunRow(Row(again + "/checkpoints/best.safetensors"), example.problem);
  CHECK(same.instances == estimate.instances);
  const std::string prosac = "{type: prosac, instances: {search: chosen, chooser: '" + best + "'}}";
  CHECK(RunRow(prosac, example.problem).status == Status::kOk);
  CHECK(RunRow(Row(best, ", least_value: 1.0"), example.problem).status == Status::kNoModel);
}

TEST_CASE("a search by a chooser says what it needs") {
  const auto error = [](const std::string& row, Task task) {
    return ErrorOf([&] { MakeEstimator(ConfigFromYaml(row, "row.yaml"), task, {}); });
  };
  CHECK(Has(error("{type: ransac, instances: {search: chosen}}", Task::kVanishingPoint), "chooser"));
  CHECK(Has(error(Row("nothing.safetensors"), Task::kVanishingPoint), "nothing.safetensors"));
  CHECK(Has(error("{type: ransac, instances: {search: sequential, chooser: a}}", Task::kVanishingPoint), "chooser"));
  const TemporaryFolder folder;
  WriteRooms(folder.path());
  Config config = TinyConfig(folder.path());
  SetYaml(&config, "task=line");
  CHECK(Has(ErrorOf([&] { Train(OneThread(config, folder / "run"), kNever); }), "vanishing_point"));
}

TEST_CASE("few segments, none, equal ones and those that are no numbers give a status") {
  Problem problem;
  problem.task = Task::kVanishingPoint;
  problem.inlier_threshold = 2.0;
  problem.size1 = {640, 480};
  const std::string row = "{type: ransac, sampling: {sampler: weighted}, instances: {search: sequential}}";
  const auto status = [&](const PointMatrix& segments) {
    problem.points = segments;
    return RunRow(row, problem).status;
  };
  CHECK(status(PointMatrix(0, 4)) == Status::kTooFewPoints);
  PointMatrix one(1, 4);
  one << 0, 0, 10, 10;
  CHECK(status(one) == Status::kTooFewPoints);
  CHECK(status(one.replicate(5, 1)) == Status::kDegenerate);
  PointMatrix points(3, 4);
  points << 1, 1, 1, 1, 2, 2, 2, 2, 3, 4, 3, 4;
  CHECK(status(points) == Status::kDegenerate);
  points(0, 0) = std::nan("");
  CHECK(status(points) != Status::kOk);
}

}  // namespace diffsac
