// The task of absolute poses: its description, its generated scenes and its files.

#include <H5Cpp.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <mutex>

#include "core/errors.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/sample_consensus.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/example_test_util.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/ground_truth/labels.h"
#include "lab/ground_truth/task_truth.h"

namespace diffsac {
namespace {

std::unique_ptr<Dataset> Generated(const std::string& more = "") {
  return MakeDataset(ConfigFromYaml("{type: synthetic_absolute_pose" + more + "}", "a.yaml"), 1);
}

AbsolutePose::Parameters Moved(const AbsolutePose::Parameters& pose, double degrees, const Eigen::Vector3d& shift) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(degrees * M_PI / 180.0, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Matrix3d rotation = RotationOf(pose);
  const Eigen::Vector3d centre = -rotation.transpose() * TranslationOf(pose) + shift;
  return PoseOf(turn * rotation, -turn * rotation * centre);
}

}  // namespace

TEST_CASE("absolute poses: the error is the turn, and the angle under which the scene sees the centres") {
  Example example;
  example.problem.task = Task::kAbsolutePose;
  // About the origin; the camera 10 away.
  example.problem.points = PointMatrix::Zero(4, 5);
  example.problem.points.leftCols(3) << 1, 0, 0, -1, 0, 0, 0, 1, 1, 0, -1, -1;
  const AbsolutePose::Parameters truth = PoseOf(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 10));
  example.truth.model = truth;
  const auto error = [&](const AbsolutePose::Parameters& pose) {
    const ModelParameters model = pose;
    return TruthOf(Task::kAbsolutePose).error(&model, {}, example);
  };
  CHECK(error(truth).angle_deg == Approx(0.0).margin(1e-6));
  const EstimateError turned = error(Moved(truth, 3.0, Eigen::Vector3d::Zero()));
  CHECK(turned.rotation_deg == Approx(3.0));
  CHECK(turned.translation_deg == Approx(0.0).margin(1e-9));
  CHECK(turned.angle_deg == Approx(3.0));
  const EstimateError moved = error(Moved(truth, 0.0, Eigen::Vector3d(1, 0, 0)));
  CHECK(moved.rotation_deg == Approx(0.0).margin(1e-6));
  CHECK(moved.offset == Approx(1.0));
  CHECK(moved.translation_deg == Approx(std::atan(0.1) * 180.0 / M_PI));
  CHECK(moved.angle_deg == moved.translation_deg);
  const EstimateError failed = TruthOf(Task::kAbsolutePose).error(nullptr, {}, example);
  CHECK(failed.failed);
  CHECK(failed.rotation_deg == 180.0);
  CHECK(failed.translation_deg == 90.0);
  CHECK(std::isinf(failed.offset));
  example.truth.model.resize(0);
  CHECK(std::isnan(error(truth).angle_deg));
}

TEST_CASE("absolute poses need a calibration, and are solved on rays") {
  Problem problem = Generated()->Get(0).problem;
  CHECK(HasItsNeeds(problem));
  CHECK(CheckProblem(problem) == Status::kOk);
  const NormalizedProblem space(problem);
  const Eigen::Matrix3d K = problem.cameras->K1;
  CHECK(space.unit() == Approx(0.5 * (K(0, 0) + K(1, 1))));
  CHECK(space.threshold() == Approx(problem.inlier_threshold / K(0, 0)));
  CHECK(space.points()(0, 3) == Approx((problem.points(0, 3) - K(0, 2)) / K(0, 0)));
  CHECK(space.points().leftCols(3) == problem.points.leftCols(3));
  CHECK(ImagePoints(problem) == problem.points.rightCols(2));
  problem.cameras->K1(0, 0) = 0.0;
  CHECK(CheckProblem(problem) == Status::kDegenerate);
  problem.cameras.reset();
  CHECK(CheckProblem(problem) == Status::kDegenerate);
}

TEST_CASE("generated scenes: the inliers are those of the truth, in number and place") {
  const auto dataset = Generated(", num_points: 150, outlier_ratio: 0.4, noise_px: 0.5");
  for (int index = 0; index < 20; ++index) {
    const Example example = dataset->Get(index);
    REQUIRE(example.problem.points.rows() == 150);
    const Eigen::Matrix3d& calibration = example.problem.cameras->K1;
    CHECK(2.0 * calibration(0, 2) == example.problem.size1.width);
    CHECK(2.0 * calibration(1, 2) == example.problem.size1.height);
    const auto within = AbsolutePoseInliers(example.problem, example.truth.model);
    int all = 0, both = 0;
    for (int i = 0; i < 150; ++i) {
      all += example.truth.inliers[i];
      both += example.truth.inliers[i] && within[i];
    }
    CHECK(all >= 90);
    CHECK(all <= 93);
    CHECK(both == all);
    CHECK(dataset->Get(index).problem.points == example.problem.points);
    CHECK(OptimalMinimalSets(example, LabelOptions{}, 4).size() == 4);
  }
  CHECK_FALSE(testing::SamePoints(Generated(", split: test")->Get(0).problem.points,
                                  Generated(", split: train")->Get(0).problem.points));
}

TEST_CASE("generated flat scenes are on a plane, and poses are found there as well") {
  const auto dataset = Generated(", num_points: 100, outlier_ratio: 0.3, flatness: 1");
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.final_refinement = FinalRefinement::kRefinement;
  options.max_iterations = 200;
  int good = 0;
  for (int index = 0; index < 10; ++index) {
    const Example example = dataset->Get(index);
    const PointMatrix centred =
        example.problem.points.leftCols(3).rowwise() - example.problem.points.leftCols(3).colwise().mean();
    const Eigen::Vector3d spread = Eigen::JacobiSVD<Eigen::MatrixXd>(centred).singularValues();
    CHECK(spread[2] < 1e-9 * spread[0]);
    const NormalizedProblem space(example.problem);
    UniformSampler source(100, 3, Rng(1));
    const auto result = SampleConsensus<AbsolutePose>(space.points(), space.threshold(), source, options, Rng(1));
    if (result.status != Status::kOk) continue;
    good += TruthOf(Task::kAbsolutePose).error(&result.model, result.inliers, example).angle_deg < 1.0;
  }
  CHECK(good >= 9);
}

TEST_CASE("files of scene points: what is read, which matches, and what is wrong with a file") {
  TemporaryFolder folder;
  const std::string path = folder / "house/scene_points.h5";
  std::filesystem::create_directories(folder / "house");
  const auto open = [&](const std::string& more = "") {
    return MakeDataset(ConfigFromYaml("{type: absolute_poses, paths: [" + folder.path() + "]" + more + "}", "a.yaml"),
                       1);
  };
  const auto error = [&] { return ErrorOf([&] { open(); }); };
  CHECK(Has(error(), "no scene_points.h5"));
  const auto write = [&](hsize_t columns, hsize_t ratios, double focal, bool pose) {
    const std::lock_guard lock(Hdf5Mutex());
    H5::H5File file(path, H5F_ACC_TRUNC);
    const H5::Group group = file.createGroup("a");
    const auto put = [&](const char* name, std::vector<double> values, std::vector<hsize_t> shape) {
      group.createDataSet(name, H5::PredType::IEEE_F64LE, H5::DataSpace(static_cast<int>(shape.size()), shape.data()))
          .write(values.data(), H5::PredType::NATIVE_DOUBLE);
    };
    std::vector<double> points;
    for (int i = 0; i < 4; ++i)
      for (hsize_t j = 0; j < columns; ++j) points.push_back(i == static_cast<int>(j) ? 1.0 : 0.0);
    put("points", points, {4, columns});
    put("ratios", std::vector<double>({0.9, 0.5, 0.7, 0.99, 0.1}), {ratios});
    put("K", {focal, 0, 0, 0, focal, 0, 0, 0, 1}, {3, 3});
    if (pose) put("pose", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5}, {3, 4});
  };
  write(5, 4, 100.0, true);
  const Example all = open()->Get(0);
  CHECK(all.id == "house/a");
  CHECK(all.scene == "house");
  CHECK(all.problem.points.rows() == 4);
  CHECK(all.truth.model.size() == 12);
  CHECK(all.truth.model[11] == 5.0);
  CHECK(all.problem.inlier_threshold == 4.0);
  // (1, 0, 0) is seen at 20 px, not at 0; (0, 0, 1) where it is.
  CHECK(all.truth.inliers == std::vector<std::uint8_t>{0, 0, 1, 1});
  const Example sound = open(", max_ratio: 0.8, inlier_threshold_px: 2")->Get(0);
  CHECK(sound.problem.snn_ratio == Eigen::Vector2d(0.5, 0.7));
  CHECK(sound.truth.inliers == std::vector<std::uint8_t>{0, 1});
  write(5, 4, 100.0, false);
  CHECK(open()->Get(0).truth.model.size() == 0);

  write(4, 4, 100.0, true);
  CHECK(Has(error(), "a/points: found 4x4"));
  write(5, 3, 100.0, true);
  CHECK(Has(error(), "a/ratios: expected one for each row"));
  write(5, 4, 0.0, true);
  CHECK(Has(error(), "a/K: expected a calibration matrix"));
  WriteRaw(path, "no HDF5");
  CHECK(Has(error(), "house/scene_points.h5: not a readable HDF5 file"));
}

}  // namespace diffsac
