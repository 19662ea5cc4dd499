#include "lab/data/refined_truth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/geometry/refine.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/pair_filter.h"
#include "lab/data/two_view_test_util.h"
#include "lab/truth/pair_truth.h"

namespace diffsac {
namespace {

// A pair whose given motion is turned by more than half a degree, some pixels off.
Example RoughPair() {
  Example pair = SyntheticSet(1, 300, Rng(9)).pairs.front();
  pair.scene = "scene";
  pair.truth.assignment.clear();  // inliers are to be judged by the model
  pair.truth.motion->rotation =
      Eigen::AngleAxisd(0.6 * 3.14159 / 180.0, Eigen::Vector3d(1, 2, 3).normalized()) * pair.truth.motion->rotation;
  pair.truth.essential.reset();
  pair.truth.fundamental.reset();
  CompleteTruth(pair.problem, &pair.truth);
  return pair;
}

std::int64_t Near(const Problem& problem, const GroundTruth& truth) {
  return (TruthDistances(problem, truth).array() < 1.0).count();
}

}  // namespace

TEST_CASE("a rough truth is refined on the matches near it, with and without calibration") {
  for (const bool calibrated : {true, false}) {
    Example pair = RoughPair();
    if (!calibrated) pair.problem.cameras.reset();
    const std::int64_t before = Near(pair.problem, pair.truth);
    GroundTruth refined = pair.truth;
    RefineEpipolarTruth(pair.problem, 4.0, &refined);
    CHECK(before < 150);
    CHECK(Near(pair.problem, refined) >= 165);
    CHECK(refined.motion == pair.truth.motion);
    CHECK((refined.essential == pair.truth.essential) == !calibrated);
  }
}

TEST_CASE("a truth is refined with the loss that was asked for, in pixels") {
  for (const double loss_px : {1.0, 2.5, 6.0}) {
    Example pair = RoughPair();
    pair.problem.cameras.reset();
    GroundTruth refined = pair.truth;
    RefineEpipolarTruth(pair.problem, loss_px, &refined);
    const Eigen::VectorXd near = (TruthDistances(pair.problem, pair.truth).array() <= 2.0 * loss_px).cast<double>();
    RefineOptions options;
    options.loss.scale = loss_px;
    Matrix3Parameters expected = AsParameters(*pair.truth.fundamental);
    REQUIRE(RefineFundamental(pair.problem.points, near, options, &expected).status == Status::kOk);
    CAPTURE(loss_px);
    CHECK(AsParameters(*refined.fundamental).isApprox(expected, 1e-9));
  }
}

TEST_CASE("what the matches disagree with a source's pose by") {
  const auto inliers = [](const Example& pair) {
    std::vector<int> rows;
    for (int i = 0; i < 300; ++i)
      if (i % 3 != 0) rows.push_back(i);
    return WithRows(pair, rows);
  };
  const auto disagreement = [](const Example& pair, int near) {
    return TruthDisagreementDegrees(pair.problem, pair.truth, 4.0, near);
  };
  const Example rough = inliers(RoughPair()), sound = inliers(SyntheticSet(1, 300, Rng(9)).pairs.front());
  CHECK(disagreement(rough, 20) > 0.5);
  CHECK(disagreement(rough, 20) < 1.0);
  CHECK(disagreement(sound, 20) < 1e-3);
  CHECK(std::isinf(disagreement(sound, 10000)));
  Example blind = sound;
  blind.problem.cameras.reset();
  CHECK(std::isnan(disagreement(blind, 20)));
}

TEST_CASE("a truth with too few matches near it stays") {
  Example pair = RoughPair();
  pair.problem.points.conservativeResize(12, 4);
  GroundTruth refined = pair.truth;
  RefineEpipolarTruth(pair.problem, 4.0, &refined);
  CHECK(refined.fundamental == pair.truth.fundamental);
}

TEST_CASE("examples for training have the refined inliers and the given pose") {
  Example given = RoughPair(), refined = RoughPair();
  RefineEpipolarTruth(refined.problem, 4.0, &refined.truth);
  for (Example* pair : {&given, &refined}) SetTask(Task::kEssential, 1.0, pair);
  const auto inliers = [](const Example& e) { return std::count(e.truth.inliers.begin(), e.truth.inliers.end(), 1); };
  CHECK(inliers(refined) > inliers(given) + 40);
  CHECK(refined.truth.pose->rotation == given.truth.pose->rotation);
  CHECK(refined.problem.points == given.problem.points);
}

}  // namespace diffsac
