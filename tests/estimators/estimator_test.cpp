#include "diffsac/estimators/estimator.h"

#include <catch2/catch.hpp>

#include "core/errors.h"
#include "diffsac/diffsac.h"
#include "diffsac/estimators/classical.h"
#include "diffsac/estimators/presets.h"
#include "diffsac/problem/tasks.h"
#include "estimators/owned_matches.h"
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
  problem.match_ratio = Eigen::VectorXd::Constant(60, 0.6);
  return problem;
}

}  // namespace

TEST_CASE("an estimator that is kept says what the functions say, problem by problem") {
  const Estimator estimator(Task::kEssential);
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Problem problem = Calibrated(seed);
    testing::OwnedMatches matches{problem.points.leftCols(2), problem.points.rightCols(2), problem.match_ratio};
    ImageOptions options;
    options.seed = seed;
    options.max_residual = 1.0;
    const TwoViewEstimate once = EstimateEssential(matches, *problem.cameras, options);
    const Estimate kept = estimator.Run(problem, seed);
    REQUIRE(once.ok());
    REQUIRE(kept.status == Status::kOk);
    CHECK(ModelMatrix(kept.model) == once.model);
    CHECK(kept.inliers == once.inliers);
    CHECK(kept.report.draws == once.stats.draws);
    CHECK(estimator.Run(problem, seed).model == kept.model);
  }
}

TEST_CASE("estimators are kept by what makes them") {
  EstimateOptions options;
  const auto first = KeptEstimator(Task::kEssential, options);
  options.seed = 5;
  CHECK(KeptEstimator(Task::kEssential, options) == first);
  CHECK(KeptEstimator(Task::kEssential, options, true) != first);
  CHECK(KeptEstimator(Task::kFundamental, options) != first);
  options.max_iterations = 30;
  const auto other = KeptEstimator(Task::kEssential, options);
  CHECK(other != first);
  CHECK(other->Run(Calibrated(1)).report.draws <= 30);
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

TEST_CASE("noise scales of a problem are those of the options times its factors") {
  Problem problem = Calibrated(2);
  ClassicalOptions options = RecommendedClassical(Task::kEssential);
  const ClassicalEstimator plain(options);
  options.consensus.least_scale *= 0.5;
  options.consensus.greatest_scale *= 3.0;
  const Estimate by_options = ClassicalEstimator(options).Run(problem, 1);
  problem.least_scale_factor = 0.5;
  problem.greatest_scale_factor = 3.0;
  const Estimate by_problem = plain.Run(problem, 1);
  REQUIRE(by_problem.status == Status::kOk);
  CHECK(by_problem.model == by_options.model);
  CHECK(by_problem.noise_scale == by_options.noise_scale);
}

}  // namespace diffsac
