#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/diffsac.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/presets.h"
#include "diffsac/problem/tasks.h"
#include "estimate/owned_matches.h"
#include "lab/data/synthetic_two_view.h"
#include "lab/ground_truth/task_truth.h"

namespace diffsac {
namespace {

enum class Kind { kGeneral, kForward, kPlanar };
constexpr Kind kGeneral = Kind::kGeneral, kForward = Kind::kForward, kPlanar = Kind::kPlanar;

Example Generated(const std::string& task, Kind kind, int index, double outliers = 0.4) {
  SyntheticTwoViewOptions options;
  options.task = TaskFromString(task);
  options.matches.outlier_ratio = outliers;
  options.matches.num_points = 300;
  options.matches.noise_px = 0.5;
  options.cameras.principal_offset = 0.0;
  options.baseline = Range(0.2, 0.6);
  options.general = kind == kGeneral;
  options.planar = kind == kPlanar;
  options.mixed = 0.0;
  options.forward = kind == kForward;
  if (kind == kGeneral) {
    options.rotation_deg = Range(10, 25);
    options.converging = 0.0;
  }
  options.forward_cone_deg = options.forward_rotation_deg = 0.0;
  return MakeSyntheticTwoView(options, 7)->Get(static_cast<std::uint64_t>(index));
}

Estimate Estimated(const Problem& problem) {
  return ClassicalEstimator(RecommendedClassical(problem.task)).Run(problem, 1);
}

double ErrorDegrees(const Example& example, const Estimate& estimate) {
  return TruthOf(Task::kSharedFocal).error(&estimate.model, estimate.inliers, example).angle_deg;
}

Problem MatchesOf(const PointMatrix& points) {
  Problem problem;
  problem.task = Task::kSharedFocal;
  problem.points = points;
  problem.inlier_threshold = 1.0;
  problem.size1 = problem.size2 = {1000, 800};
  return problem;
}

}  // namespace

TEST_CASE("pose and focal length come from matches without a calibration") {
  int accurate = 0, within = 0, observable = 0;
  constexpr int kProblems = 12;
  for (int i = 0; i < kProblems; ++i) {
    const Example example = Generated("shared_focal", kGeneral, i);
    REQUIRE_FALSE(example.problem.cameras);
    const Estimate estimate = Estimated(example.problem);
    REQUIRE(estimate.status == Status::kOk);
    REQUIRE(estimate.focal);
    const double truth = example.truth.cameras->K1(0, 0);
    accurate += ErrorDegrees(example, estimate) < 10.0 ? 1 : 0;
    within += std::abs(estimate.focal->focal_px[0] / truth - 1.0) < 0.15 ? 1 : 0;
    observable += estimate.focal->observable[0] ? 1 : 0;
    CHECK(estimate.focal->low_px[0] <= estimate.focal->high_px[0]);
    CHECK(estimate.focal->focal_px[0] == estimate.focal->focal_px[1]);
  }
  CAPTURE(accurate, within, observable);
  CHECK(accurate >= 9);
  CHECK(within >= 8);
  CHECK(observable >= 9);
}

TEST_CASE("straight ahead, and on one plane, the focal length is the prior's and said not to be observable") {
  int forward = 0, planar = 0;
  constexpr int kProblems = 8;
  for (int i = 0; i < kProblems; ++i) {
    const Estimate ahead = Estimated(Generated("shared_focal", kForward, i).problem);
    REQUIRE(ahead.focal);
    forward += ahead.focal->observable[0] ? 0 : 1;
    if (!ahead.focal->observable[0])
      CHECK(std::abs(std::log(ahead.focal->focal_px[0] / ahead.focal->prior_focal_px[0])) <
            ahead.focal->prior_log_sigma[0]);
    // Without outliers: a few of them in an epipolar band would choose among the epipoles that a plane leaves.
    const Estimate plane = Estimated(Generated("shared_focal", kPlanar, i, 0.0).problem);
    REQUIRE(plane.focal);
    planar += plane.focal->observable[0] ? 0 : 1;
  }
  CAPTURE(forward, planar);
  CHECK(forward >= 7);
  CHECK(planar >= 5);
}

TEST_CASE("with one camera calibrated the other one's focal length is found") {
  int within = 0;
  for (int i = 0; i < 8; ++i) {
    const Example example = Generated("one_focal", kGeneral, i);
    REQUIRE(example.problem.camera_prior1.K);
    const Estimate estimate = Estimated(example.problem);
    REQUIRE(estimate.focal);
    CHECK(estimate.focal->focal_px[0] == Approx(example.truth.cameras->K1(0, 0)));
    within += std::abs(estimate.focal->focal_px[1] / example.truth.cameras->K2(0, 0) - 1.0) < 0.1 ? 1 : 0;
  }
  CHECK(within >= 6);
}

TEST_CASE("photographs by two cameras have two focal lengths, each with its interval, and their pose") {
  int accurate = 0, within = 0, held = 0, lengths = 0;
  for (int i = 0; i < 12; ++i) {
    const Example example = Generated("two_focals", kGeneral, i);
    REQUIRE_FALSE(example.problem.cameras);
    const Estimate estimate = Estimated(example.problem);
    REQUIRE(estimate.status == Status::kOk);
    REQUIRE(estimate.focal);
    accurate += TruthOf(Task::kTwoFocals).error(&estimate.model, estimate.inliers, example).angle_deg < 10.0 ? 1 : 0;
    for (int k = 0; k < 2; ++k, ++lengths) {
      const double truth = (k == 0 ? example.truth.cameras->K1 : example.truth.cameras->K2)(0, 0);
      within += std::abs(estimate.focal->focal_px[k] / truth - 1.0) < 0.2 ? 1 : 0;
      held += estimate.focal->low_px[k] <= truth && truth <= estimate.focal->high_px[k] ? 1 : 0;
    }
  }
  CAPTURE(accurate, within, held, lengths);
  CHECK(accurate >= 8);
  CHECK(within >= 14);
  CHECK(held >= 12);
}

TEST_CASE("images in the other order have the other order's focal lengths") {
  const Example example = Generated("two_focals", kGeneral, 3);
  Problem swapped = example.problem;
  swapped.points << example.problem.points.rightCols(2), example.problem.points.leftCols(2);
  std::swap(swapped.size1, swapped.size2);
  std::swap(swapped.camera_prior1, swapped.camera_prior2);
  const Estimate one = Estimated(example.problem), other = Estimated(swapped);
  REQUIRE(one.focal);
  REQUIRE(other.focal);
  for (int k = 0; k < 2; ++k) CHECK(other.focal->focal_px[1 - k] == Approx(one.focal->focal_px[k]).epsilon(0.05));
}

TEST_CASE("a narrow prior of its own is the problem's") {
  Example example = Generated("shared_focal", kGeneral, 0);
  const double truth = example.truth.cameras->K1(0, 0);
  example.problem.camera_prior1.focal = example.problem.camera_prior2.focal = FocalPrior{1.1 * truth, 1e-4};
  const Estimate estimate = Estimated(example.problem);
  REQUIRE(estimate.focal);
  CHECK(estimate.focal->focal_px[0] == Approx(1.1 * truth).epsilon(0.01));
  CHECK(estimate.focal->prior_log_sigma[0] == 1e-4);
}

TEST_CASE("degenerate matches have a status, with an unknown focal length too") {
  const PointMatrix points = Generated("shared_focal", kGeneral, 1).problem.points;
  CHECK(Estimated(MatchesOf(points.topRows(5))).status == Status::kTooFewPoints);
  PointMatrix broken = points;
  broken(7, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK(Estimated(MatchesOf(broken)).num_nonfinite == 1);
  PointMatrix line = points;
  line.col(1) = 2.0 * line.col(0);
  CHECK(Estimated(MatchesOf(line)).status == Status::kDegenerate);
  CHECK(Estimated(MatchesOf(points.row(0).replicate(20, 1))).status == Status::kDegenerate);
  Problem unsized = MatchesOf(points);
  unsized.size1 = unsized.size2 = {};
  CHECK(Estimated(unsized).status == Status::kDegenerate);
  // γ − 1, γ and identical cameras: no crash, and no focal length that the matches would not show.
  CHECK(Estimated(MatchesOf(points.topRows(6))).status != Status::kTooFewPoints);
  PointMatrix still = points;
  still.rightCols(2) = still.leftCols(2);
  const Estimate same = Estimated(MatchesOf(still));
  if (same.focal) CHECK_FALSE(same.focal->observable[0]);
}

TEST_CASE("the functions of the header say the same, in pixels") {
  const Example example = Generated("shared_focal", kGeneral, 2);
  const Problem& problem = example.problem;
  const testing::OwnedMatches matches{problem.points.leftCols(2), problem.points.rightCols(2), problem.snn_ratio,
                                      problem.size1, problem.size2};
  FocalOptions options;
  options.seed = 1;
  const UnknownFocalEstimate result = EstimateSharedFocal(matches, options);
  const Estimate row = Estimated(problem);
  REQUIRE(result.ok());
  REQUIRE(result.focal);
  REQUIRE(result.pose);
  CHECK(result.inliers == row.inliers);
  CHECK(result.focal->focal_px[0] == row.focal->focal_px[0]);
  CHECK(result.cameras.K1(0, 0) == Approx(result.focal->focal_px[0]));
  CHECK(result.cameras.K1(0, 2) == Approx(0.5 * (problem.size1.width - 1)));
  for (Eigen::Index i = 0; i < problem.points.rows(); ++i)
    if (result.inliers[i])
      CHECK(SampsonError(AsParameters(result.model), problem.points.row(i).data()) <=
            result.inlier_threshold * (1.0 + 1e-9));
  testing::OwnedMatches unsized = matches;
  unsized.size1 = {};
  CHECK_THROWS_AS(EstimateSharedFocal(unsized), Error);
  FocalOptions wrong;
  wrong.prior = FocalPrior{100.0, 0.0};
  CHECK_THROWS_AS(EstimateSharedFocal(matches, wrong), Error);
  const UnknownFocalEstimate one = EstimateOneFocal(matches, example.truth.cameras->K1);
  REQUIRE(one.ok());
  CHECK(one.cameras.K1(0, 0) == Approx(example.truth.cameras->K1(0, 0)));
  FocalOptions narrow;
  narrow.prior = FocalPrior{700.0, 1e-4};
  narrow.prior2 = FocalPrior{900.0, 1e-4};
  const UnknownFocalEstimate two = EstimateTwoFocals(matches, narrow);
  REQUIRE(two.ok());
  CHECK(two.cameras.K1(0, 0) == Approx(700.0).epsilon(0.01));
  CHECK(two.cameras.K2(0, 0) == Approx(900.0).epsilon(0.01));
  narrow.prior2->focal = -1.0;
  CHECK_THROWS_WITH(EstimateTwoFocals(matches, narrow), Catch::Contains("prior2.focal"));
}

}  // namespace diffsac
