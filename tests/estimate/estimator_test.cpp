#include "diffsac/estimate/estimator.h"

#include <catch2/catch.hpp>

#include "core/errors.h"
#include "diffsac/diffsac.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/presets.h"
#include "diffsac/estimate/second_search.h"
#include "diffsac/problem/tasks.h"
#include "estimate/owned_matches.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

Problem Calibrated(std::uint64_t seed) {
  Rng rng(seed);
  Problem problem;
  problem.task = Task::kEssential;
  problem.inlier_threshold = 1.0;
  problem.cameras = CameraPair{Eigen::Vector3d(800, 800, 1).asDiagonal(), Eigen::Vector3d(800, 800, 1).asDiagonal()};
  problem.points = 800.0 * testing::RandomProblem(60, rng).normalized;
  for (int i = 0; i < 20; ++i) problem.points.row(i) = 400.0 * Eigen::RowVector4d::Random();
  problem.snn_ratio = Eigen::VectorXd::Constant(60, 0.6);
  return problem;
}

}  // namespace

TEST_CASE("an estimator that is kept says what the functions say, problem by problem") {
  const Estimator estimator(Task::kEssential);
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Problem problem = Calibrated(seed);
    testing::OwnedMatches matches{problem.points.leftCols(2), problem.points.rightCols(2), problem.snn_ratio};
    ImageOptions options;
    options.seed = seed;
    options.max_residual = 1.0;
    const TwoViewEstimate once = EstimateEssential(matches, *problem.cameras, options);
    const Estimate kept = estimator.Run(problem, seed);
    REQUIRE(once.ok());
    REQUIRE(kept.status == Status::kOk);
    CHECK(ModelMatrix(kept.model) == once.model);
    CHECK(kept.inliers == once.inliers);
    CHECK(kept.stats.iterations == once.stats.iterations);
    CHECK(estimator.Run(problem, seed).model == kept.model);
  }
}

TEST_CASE("estimators are kept by what makes them") {
  EstimateOptions options;
  const auto first = CachedEstimator(Task::kEssential, options);
  options.seed = 5;
  CHECK(CachedEstimator(Task::kEssential, options) == first);
  CHECK(CachedEstimator(Task::kEssential, options, true) != first);
  CHECK(CachedEstimator(Task::kFundamental, options) != first);
  options.max_iterations = 30;
  const auto other = CachedEstimator(Task::kEssential, options);
  CHECK(other != first);
  CHECK(other->Run(Calibrated(1)).stats.iterations <= 30);
}

TEST_CASE("what an estimator cannot do is said") {
  EstimateOptions options;
  options.max_iterations = -1;
  CHECK(Has(ErrorOf([&] { Estimator(Task::kEssential, options); }), "max_iterations: expected from 1"));
  const Estimator estimator(Task::kFundamental);
  CHECK(Has(ErrorOf([&] { estimator.Run(Calibrated(0)); }), "problem.task: expected fundamental, got essential"));
  options = {};
  options.models_folder = "/none";
  const Estimator without(Task::kEssential, options);
  CHECK(Has(ErrorOf([&] { without.Run(Calibrated(0)); }), "/none/essential/model.safetensors"));
}

TEST_CASE("another threshold widens the range of scales") {
  Problem problem = Calibrated(2);
  SetThreshold(DefaultThreshold(Task::kEssential), &problem);
  CHECK(NoiseRangeOf(problem, true).least == 1.0);
  CHECK(NoiseRangeOf(problem, true).greatest == 1.0);
  SetThreshold(40.0, &problem);
  CHECK(NoiseRangeOf(problem, false).greatest == 1.0);
  CHECK(NoiseRangeOf(problem, true).greatest == 40.0);
  CHECK(NoiseRangeOf(problem, true).least < 5.0);
  SetThreshold(1e-3, &problem);
  CHECK(NoiseRangeOf(problem, true).least == 1e-3);
  CHECK(NoiseRangeOf(problem, true).greatest > 0.1);
}

TEST_CASE("one search is enough without doubts") {
  const Problem problem = Calibrated(0);
  const PreparedProblem prepared(problem);
  const ClassicalEstimator once(LoRansacOptions(Task::kEssential));
  const Estimate estimate = once.Run(problem, 1);
  REQUIRE(estimate.IsSure());
  CHECK(ReasonToSearch(prepared, estimate) == SearchReason::kNone);
}

}  // namespace diffsac
