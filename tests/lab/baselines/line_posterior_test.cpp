#include <catch2/catch.hpp>
#include <limits>

#include "diffsac/estimators/classical.h"
#include "diffsac/problem/tasks.h"
#include "estimators/make_estimator.h"
#include "lab/data/synthetic.h"

namespace diffsac {
namespace {

std::unique_ptr<Dataset> Lines(double outlier_ratio) {
  SyntheticOptions options;
  options.model_sampling = ModelSampling::kThroughPoint;
  options.outlier_ratio = {outlier_ratio, outlier_ratio};
  return MakeSynthetic(Task::kLine, options, 1);
}

double MeanError(const RobustEstimator& method, const Dataset& lines, int count) {
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const Example example = lines.Get(i);
    const Estimate estimate = method.Run(example.problem, 1);
    REQUIRE(estimate.status == Status::kOk);
    CHECK(estimate.score > 0.0);
    CHECK(estimate.score <= 100.0 + 1e-9);
    sum += std::min(1.0, AngleBetweenDegrees(estimate.model, example.truth.model));
  }
  return sum / count;
}

TEST_CASE("The Bayes estimate is at least as good as a plain RANSAC and as exhaustive search within sampling error") {
  const auto lines = Lines(0.8);
  const double bayes = MeanError(*MakeRow("line_posterior", Task::kLine), *lines, 200);
  const auto ransac = MakeRow("ransac", Task::kLine, "max_iterations: 1000");
  const auto exhaustive = MakeRow("exhaustive", Task::kLine);
  CHECK(bayes < MeanError(*ransac, *lines, 200));
  CHECK(bayes < 1.05 * MeanError(*exhaustive, *lines, 200));
}

TEST_CASE("The Bayes estimate of few, equal or non-finite points is a status") {
  const auto method = MakeRow("line_posterior", Task::kLine);
  Problem problem;
  problem.points.resize(1, 2);
  problem.points << 1, 2;
  CHECK(method->Run(problem, 1).status == Status::kTooFewPoints);
  problem.points = PointMatrix::Constant(10, 2, 3.0);
  CHECK(method->Run(problem, 1).status == Status::kDegenerate);
  problem.points = Lines(0.5)->Get(0).problem.points;
  problem.points.col(1).setConstant(std::numeric_limits<double>::quiet_NaN());
  CHECK(method->Run(problem, 1).status == Status::kTooFewPoints);
  problem.points = Lines(0.5)->Get(0).problem.points;
  problem.inlier_threshold = 0.0;
  CHECK(method->Run(problem, 1).status == Status::kNoModel);
  // Outside the picture the prior is 0 everywhere.
  problem.inlier_threshold = 0.1;
  problem.points.array() += 100.0;
  CHECK(method->Run(problem, 1).status == Status::kNoModel);
}

TEST_CASE("The Bayes estimate is for lines alone") {
  CHECK_THROWS_AS(MakeRow("line_posterior", Task::kPlane), Error);
  CHECK(MakeRow("line_posterior", Task::kLine, "candidates: 5") != nullptr);
}

}  // namespace
}  // namespace diffsac
