#include "lab/eval/problem_quantities.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "diffsac/geometry/pose.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

/// Four matches of a camera that moves by 2 along x: image rows are kept, the second view's are off by 0, 1.2, 1.8 and
/// 9 pixels, Sampson distances of these over √2.
Example SidewaysPair() {
  Example pair;
  pair.problem.points.resize(4, 4);
  pair.problem.points << 10, 10, 40, 10, 50, 20, 90, 21.2, 70, 30, 80, 31.8, 90, 40, 95, 49;
  pair.truth.motion = RigidMotion{Eigen::Matrix3d::Identity(), Eigen::Vector3d(-2.0, 0.0, 0.0)};
  pair.truth.fundamental = EssentialFromMotion(*pair.truth.motion);
  SetTask(TaskFromString("fundamental"), 1.0, &pair);
  return pair;
}

ProblemRecord Recorded(const Example& example, double within_px = 0.0) {
  ProblemRecord record;
  record.points = static_cast<int>(example.problem.points.rows());
  RecordQuantities(example, within_px, &record);
  return record;
}

TEST_CASE("the share of true inliers is that of the data's threshold, or of another") {
  const Example pair = SidewaysPair();
  CHECK(Recorded(pair).inlier_share == 0.5);  // 0, .85; ε is 1.
  CHECK(Recorded(pair, 0.5).inlier_share == 0.25);
  CHECK(Recorded(pair, 1.5).inlier_share == 0.75);  // 1.27 as well.
  CHECK(Recorded(pair, 100.0).inlier_share == 1.0);
}

TEST_CASE("labels are the truth whatever the threshold") {
  Example pair = SidewaysPair();
  pair.truth.assignment = {0, 1, 2, 1};
  SetTask(pair.problem.task, 1.0, &pair);
  CHECK(Recorded(pair).inlier_share == 0.75);
  CHECK(Recorded(pair, 1.5).inlier_share == 0.75);
}

TEST_CASE("the true motion's angle and length") {
  Example pair = SidewaysPair();
  CHECK(Recorded(pair).true_rotation_deg == Approx(0.0).margin(1e-6));
  CHECK(Recorded(pair).true_baseline == 2.0);
  pair.truth.motion->rotation = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()).toRotationMatrix();
  pair.truth.motion->translation.setZero();
  SetTask(pair.problem.task, 1.0, &pair);
  CHECK(Recorded(pair).true_rotation_deg == Approx(0.5 * 180.0 / M_PI));
  CHECK(Recorded(pair).true_baseline == 0.0);
}

TEST_CASE("parallax is the median angle of the true inliers' rays") {
  Example pair = SidewaysPair();
  pair.problem.cameras = CameraPair();
  pair.problem.cameras->K1.diagonal() << 100.0, 100.0, 1.0;
  pair.problem.cameras->K2 = pair.problem.cameras->K1;
  pair.truth.inliers = {1, 0, 0, 1};
  const auto angle = [](double x1, double y1, double x2, double y2) {
    return DirectionAngleDegrees(Eigen::Vector3d(x1, y1, 1.0), Eigen::Vector3d(x2, y2, 1.0));
  };
  CHECK(Recorded(pair).true_parallax_deg == Approx((angle(0.1, 0.1, 0.4, 0.1) + angle(0.9, 0.4, 0.95, 0.49)) / 2.0));
  // Turned with the second camera nothing is changed but its rays.
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const double before = Recorded(pair).true_parallax_deg;
  pair.truth.pose->rotation = turn;
  for (Eigen::Index i = 0; i < 4; ++i) {
    const Eigen::Vector3d turned = turn * Eigen::Vector3d(pair.problem.points(i, 2), pair.problem.points(i, 3), 100.0);
    pair.problem.points.row(i).tail<2>() << turned[0], turned[1];
  }
  CHECK(Recorded(pair).true_parallax_deg == Approx(before));
  pair.truth.inliers.assign(4, 0);
  CHECK(std::isnan(Recorded(pair).true_parallax_deg));
  pair.problem.cameras.reset();
  CHECK(std::isnan(Recorded(pair).true_parallax_deg));
}

TEST_CASE("what the truth does not say is unknown") {
  Example pair = SidewaysPair();
  pair.truth = {};
  CHECK(std::isnan(Recorded(pair).inlier_share));
  CHECK(std::isnan(Recorded(pair, 1.5).inlier_share));
  CHECK(std::isnan(Recorded(pair).true_rotation_deg));
  CHECK(std::isnan(Recorded(pair).true_baseline));
  Example nothing;
  nothing.truth.inliers = {};
  nothing.problem.points.resize(0, 2);
  CHECK(std::isnan(Recorded(nothing).inlier_share));
  const ProblemRecord lines = Recorded(testing::LinesCross());
  CHECK(lines.inlier_share == Approx(30.0 / 36.0));
  CHECK(std::isnan(lines.true_rotation_deg));
}

TEST_CASE("a run records what its problems are like") {
  const ExperimentResults results = RunExperiment(testing::SmallExperiment(), testing::TwoPointInputs());
  for (const Cell& cell : results.cells)
    for (const ProblemRecord& record : cell.records)
      CHECK(record.inlier_share == Approx(cell.condition == 0 ? 0.8 : 0.5));
}

}  // namespace
}  // namespace diffsac
