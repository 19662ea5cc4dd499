// Several structures: what counts as wrong and as found.

#include "lab/ground_truth/instances_error.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/problem/tasks.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/eval/metrics.h"

namespace diffsac {
namespace {

using testing::LinesCross;
using testing::LinesFound;

// The worked example of docs/metrics.md.
const std::vector<std::int32_t> kTruth = {1, 1, 1, 1, 2, 2, 2, 3, 0, 0};
const std::vector<std::int32_t> kFound = {2, 2, 2, 0, 1, 1, 3, 3, 0, 3};

TEST_CASE("the misclassification error of the worked example") {
  CHECK(Misclassification(kFound, kTruth) == Approx(30.0));
}

TEST_CASE("no numbering of the found structures changes the error") {
  std::vector<std::int32_t> order = {1, 2, 3, 4};
  do {
    std::vector<std::int32_t> renamed = kFound;
    for (std::int32_t& label : renamed)
      if (label > 0) label = order[static_cast<std::size_t>(label) - 1];
    CHECK(Misclassification(renamed, kTruth) == Approx(30.0));
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_CASE("outliers are no structure: what is right or wrong of them") {
  const std::vector<std::int32_t> none(10, 0), all(10, 1), empty;
  CHECK(Misclassification(kTruth, kTruth) == 0.0);
  CHECK(Misclassification(none, kTruth) == Approx(80.0));  // The two outliers are right.
  CHECK(Misclassification(all, kTruth) == Approx(60.0));   // The four of the largest structure are.
  CHECK(Misclassification(all, none) == 100.0);            // No structure stands for the outliers.
  CHECK(Misclassification(none, none) == 0.0);
  CHECK(std::isnan(Misclassification(empty, empty)));
}

TEST_CASE("a perfect estimate finds all, whatever its order and signs") {
  const Example example = LinesCross();
  Estimate estimate = LinesFound(example);
  EstimateError error = MeasureError(estimate, example);
  CHECK(error.misclassified == 0.0);
  CHECK(error.recall == 1.0);
  std::swap(estimate.instances[0], estimate.instances[2]);
  estimate.instances[1] = -estimate.instances[1];
  for (std::int32_t& label : estimate.assignment) label = label == 1 ? 3 : label == 3 ? 1 : label;
  error = MeasureError(estimate, example);
  CHECK(error.misclassified == 0.0);
  CHECK(error.recall == 1.0);
}

TEST_CASE("a true structure is found by a model of its own") {
  const Example example = LinesCross();
  Estimate estimate = LinesFound(example);
  estimate.instances = {estimate.instances[0], estimate.instances[0], estimate.instances[0]};
  CHECK(MeasureError(estimate, example).recall == Approx(1.0 / 3.0));
  estimate.instances.push_back(example.truth.instances[2]);
  CHECK(MeasureError(estimate, example).recall == Approx(2.0 / 3.0));
}

TEST_CASE("a model finds a structure when its points are within the threshold, as a root mean square") {
  const Example example = LinesCross();  // Its threshold is 0.1.
  Estimate estimate = LinesFound(example);
  estimate.instances.resize(1);
  estimate.instances[0][2] += 0.099;
  CHECK(MeasureError(estimate, example).recall == Approx(1.0 / 3.0));
  estimate.instances[0][2] += 0.002;
  CHECK(MeasureError(estimate, example).recall == 0.0);
  estimate.instances[0][0] = std::nan("");
  CHECK(MeasureError(estimate, example).recall == 0.0);
}

TEST_CASE("a residual counts as three thresholds at most, one that is not finite too") {
  Example example = LinesCross();
  const Estimate estimate = LinesFound(example);
  // Of the first line's ten points one far off: sqrt(9 / 10) of a threshold. Two are sqrt(18 / 10).
  example.problem.points.row(0) << 50.0, 50.0;
  CHECK(MeasureError(estimate, example).recall == 1.0);
  example.problem.points(1, 1) = std::nan("");
  CHECK(MeasureError(estimate, example).recall == Approx(2.0 / 3.0));
}

TEST_CASE("nothing found, and failures") {
  const Example example = LinesCross();
  for (const Status status : {Status::kNoModel, Status::kDegenerate, Status::kTooFewPoints}) {
    Estimate estimate;
    estimate.status = status;
    const EstimateError error = MeasureError(estimate, example);
    CHECK(error.failed);
    CHECK(error.recall == 0.0);
    CHECK(error.misclassified == Approx(100.0 * 30.0 / 36.0));
  }
}

TEST_CASE("a row that looks for one model has found one structure") {
  const Example example = LinesCross();
  Estimate estimate = LinesFound(example);
  estimate.instances.clear();
  estimate.assignment.clear();
  estimate.inliers.assign(36, 0);
  std::fill_n(estimate.inliers.begin(), 10, 1);
  const EstimateError error = MeasureError(estimate, example);
  CHECK(error.recall == Approx(1.0 / 3.0));
  CHECK(error.misclassified == Approx(100.0 * 20.0 / 36.0));
  CHECK(InstancesOf(estimate, example.problem).models.size() == 1);
}

TEST_CASE("a structure without points is not asked for") {
  Example example = LinesCross();
  for (std::int32_t& label : example.truth.assignment)
    if (label == 3) label = 0;
  CHECK(MeasureError(LinesFound(example), example).recall == 1.0);
}

TEST_CASE("with one true model, or labels of other points, nothing is said") {
  Example example = LinesCross();
  const Estimate estimate = LinesFound(example);
  example.truth.assignment.pop_back();
  CHECK(std::isnan(MeasureError(estimate, example).recall));
  example = LinesCross();
  example.truth.instances.clear();
  const EstimateError error = MeasureError(estimate, example);
  CHECK(std::isnan(error.recall));
  CHECK(std::isnan(error.misclassified));
  CHECK(AccuracyOf(error, 0.5) == 1.0);
}

TEST_CASE("the accuracy is the recall where it is known") {
  EstimateError error;
  CHECK(std::isnan(AccuracyOf(error, 1.0)));
  error.angle_deg = 0.5;
  CHECK(AccuracyOf(error, 1.0) == AverageAccuracy(0.5, 1.0));
  error.recall = 0.25;
  CHECK(AccuracyOf(error, 1.0) == 0.25);
}

TEST_CASE("sets of one structure, and the structures that they are of") {
  const GroundTruth truth = LinesCross().truth;  // Ten points of each line, then six outliers.
  const InstanceShares shares = InstanceSharesOf({{0, 9}, {10, 11}, {9, 10}, {30, 31}, {0, 30}, {5, 3}}, truth);
  CHECK(shares.one_instance == 0.5);
  CHECK(shares.instances == Approx(2.0 / 3.0));
  CHECK(InstanceSharesOf({{30, 31}}, truth).instances == 0.0);
  CHECK(std::isnan(InstanceSharesOf({}, truth).one_instance));
  GroundTruth one = truth;
  one.instances.clear();
  CHECK(std::isnan(InstanceSharesOf({{0, 1}}, one).one_instance));
}

Example VanishingPointsOfThree() {
  Example example;
  example.problem.task = Task::kVanishingPoint;
  example.problem.points = PointMatrix::Random(4, 4);
  CameraPair cameras;
  cameras.K1 << 518.85790117450188, 0, 325.58244941119034, 0, 519.46961112127485, 253.73616633400465, 0, 0, 1;
  cameras.K2 = cameras.K1;
  example.problem.cameras = cameras;
  example.truth.instances = {Eigen::Vector3d(1, 0, 0.1), Eigen::Vector3d(0, 1, 0.1), Eigen::Vector3d(0, 0.1, 1)};
  return example;
}

// fkluger/consac, util/evaluation.py, single_eval_nyu, on the same numbers.
TEST_CASE("angles of several vanishing points are those of CONSAC's program") {
  const Example example = VanishingPointsOfThree();
  const double pixels[3][2] = {{352.7746, 305.7544}, {5511.0007, 435.0284}, {325.5824, 760.4779}};
  std::vector<ModelParameters> found;
  for (const auto& [x, y] : pixels) found.push_back(VanishingPointTask::ModelOf({x, y, 1.0}, example.problem));
  const auto check = [&](const std::vector<double>& expected) {
    const std::vector<double> angles = InstanceAngles(found, example);
    REQUIRE(angles.size() == expected.size());
    for (std::size_t i = 0; i < angles.size(); ++i) CHECK(angles[i] == Approx(expected[i]).margin(1e-5));
  };
  check({1.990073, 40.0, 2.985108});
  found.push_back(example.truth.instances[1]);  // Only as many count as there are true ones.
  check({1.990073, 40.0, 2.985108});
  found.resize(2);
  check({1.990073, 90.0, 2.985108});
  found.clear();
  check({90.0, 90.0, 90.0});
}

TEST_CASE("the sum of the angles is least, not each of them") {
  Example example = VanishingPointsOfThree();
  const auto turned = [](double degrees) {
    const double a = degrees * 3.14159265358979 / 180.0;
    return ModelParameters(Eigen::Vector3d(std::cos(a), std::sin(a), 0.0));
  };
  example.truth.instances = {turned(0), turned(20)};
  const std::vector<double> angles = InstanceAngles({turned(19), turned(22)}, example);
  CHECK(angles[0] == Approx(19.0));
  CHECK(angles[1] == Approx(2.0));
}

TEST_CASE("angles are those of the true camera where the problem has none") {
  Example example = VanishingPointsOfThree();
  const auto pixel = [&](int k) -> Eigen::Vector3d {
    return VanishingPointTask::PixelPoint(example.truth.instances[k], example.problem);
  };
  const Eigen::Vector3d first = pixel(0), second = pixel(1);
  const double angle =
      TruthOf(Task::kVanishingPoint).instance_angle(example.truth.instances[0], example.truth.instances[1], example);
  example.truth.cameras = example.problem.cameras;
  example.problem.cameras.reset();
  example.problem.size1 = {640, 480};
  CHECK(TruthOf(Task::kVanishingPoint)
            .instance_angle(VanishingPointTask::ModelOf(first, example.problem),
                            VanishingPointTask::ModelOf(second, example.problem), example) == Approx(angle));
}

}  // namespace
}  // namespace diffsac
