#include "lab/ground_truth/task_truth.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

const Eigen::Matrix3d kPureRotation =
    Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.2, 0.9, -0.1).normalized()).toRotationMatrix();
const Eigen::Vector3d kStep = Eigen::Vector3d(0.6, 0.0, -0.8);

/// A pair of calibrated views that moved by `translation`, of length 1 or 0.
Example Views(const Eigen::Vector3d& translation, Task task = Task::kEssential) {
  Example example;
  example.problem.task = task;
  if (!FindsFocals(task)) example.problem.cameras = CameraPair{};
  example.truth.pose = RelativePose{kPureRotation, translation};
  return example;
}

EstimateError ErrorOf(const std::optional<RigidMotion>& pose, const Example& example) {
  EstimateError error;
  AddPoseError(pose, example, &error);
  return error;
}

}  // namespace

TEST_CASE("a right pose has no error") {
  for (const Task task : kTwoViewTasks) {
    const EstimateError error = ErrorOf(RigidMotion{kPureRotation, 3.0 * kStep}, Views(kStep, task));
    CHECK(error.pose_rotation_deg < 1e-5);
    CHECK(error.pose_translation_deg < 1e-5);
    CHECK(error.pose_deg == std::max(error.pose_rotation_deg, error.pose_translation_deg));
    CHECK(std::isnan(error.angle_deg));  // The model's is left alone.
  }
}

TEST_CASE("a known turn is the error") {
  const Eigen::Matrix3d three(Eigen::AngleAxisd(3.0 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY()));
  EstimateError error = ErrorOf(RigidMotion{three * kPureRotation, kStep}, Views(kStep));
  CHECK(error.pose_rotation_deg == Approx(3.0));
  CHECK(error.pose_deg == error.pose_rotation_deg);
  error = ErrorOf(RigidMotion{kPureRotation, three * kStep}, Views(kStep));
  CHECK(error.pose_translation_deg == Approx(3.0));
  CHECK(error.pose_deg == error.pose_translation_deg);
}

TEST_CASE("the sign of t counts") {
  const EstimateError error = ErrorOf(RigidMotion{kPureRotation, -kStep}, Views(kStep));
  CHECK(error.pose_rotation_deg < 1e-5);
  CHECK(error.pose_translation_deg == Approx(180.0));
  CHECK(error.pose_deg == Approx(180.0));
}

TEST_CASE("a turn is wrong with a baseline") {
  const EstimateError error = ErrorOf(RigidMotion{kPureRotation, Eigen::Vector3d::Zero()}, Views(kStep));
  CHECK(error.pose_rotation_deg < 1e-5);
  CHECK(error.pose_translation_deg == kWorstPoseDeg);
  CHECK(error.pose_deg == kWorstPoseDeg);
}

TEST_CASE("a turn is right without a baseline") {
  const Example turned = Views(Eigen::Vector3d::Zero());
  EstimateError error = ErrorOf(RigidMotion{kPureRotation, Eigen::Vector3d::Zero()}, turned);
  CHECK(error.pose_translation_deg == 0.0);
  CHECK(error.pose_deg < 1e-5);
  error = ErrorOf(RigidMotion{kPureRotation, kStep}, turned);  // Says that it moved.
  CHECK(error.pose_rotation_deg < 1e-5);
  CHECK(error.pose_translation_deg == kWorstPoseDeg);
}

TEST_CASE("an absent or infinite pose is the worst") {
  for (const Eigen::Vector3d& truth : {kStep, Eigen::Vector3d(0.0, 0.0, 0.0)})
    for (const bool absent : {true, false}) {
      const RigidMotion broken{kPureRotation, Eigen::Vector3d(0.0, std::numeric_limits<double>::quiet_NaN(), 1.0)};
      const EstimateError error = ErrorOf(absent ? std::nullopt : std::optional(broken), Views(truth));
      CHECK(error.pose_rotation_deg == kWorstPoseDeg);
      CHECK(error.pose_translation_deg == kWorstPoseDeg);
      CHECK(error.pose_deg == kWorstPoseDeg);
    }
}

TEST_CASE("without true poses or cameras nothing is judged") {
  const RigidMotion right{kPureRotation, kStep};
  Example example = Views(kStep);
  example.truth.pose.reset();
  CHECK(std::isnan(ErrorOf(right, example).pose_deg));
  for (const Task task : {Task::kFundamental, Task::kHomography}) {
    example = Views(kStep, task);
    example.problem.cameras.reset();
    CHECK(std::isnan(ErrorOf(right, example).pose_deg));
  }
  CHECK(std::isnan(ErrorOf(right, Views(kStep, Task::kAbsolutePose)).pose_deg));
}

}  // namespace diffsac
