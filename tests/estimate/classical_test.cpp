#include "diffsac/estimate/classical.h"

#include <catch2/catch.hpp>
#include <limits>
#include <numeric>
#include <vector>

#include "diffsac/problem/tasks.h"
#include "estimate/make_estimator.h"
#include "lab/baselines/oracle.h"
#include "lab/config/yaml.h"
#include "ransac/random_problems.h"

namespace diffsac {
namespace {

constexpr const char* kTypes[] = {"ransac", "lo_ransac", "exhaustive", "theil_sen"};

template <int D>
Example MakeExample(int num_points, double outlier_ratio, std::uint64_t seed) {
  const auto random = testing::MakeRandomProblem<D>(num_points, outlier_ratio, 0.03, Rng(seed));
  Example example;
  example.problem = {D == 2 ? Task::kLine : Task::kPlane, random.points, 0.1};
  example.truth.model = random.truth;
  example.truth.inliers = random.inliers;
  return example;
}

std::unique_ptr<RobustEstimator> Make(const std::string& type, const std::string& yaml = "{}",
                                      Task task = Task::kLine) {
  return MakeRow(type, task, yaml);
}

int Count(const std::vector<std::uint8_t>& mask) { return std::accumulate(mask.begin(), mask.end(), 0); }

TEST_CASE("Every classical method finds lines and planes among few outliers") {
  for (const char* type : kTypes) {
    CAPTURE(type);
    const auto method = Make(type);
    REQUIRE(method);
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const Example line = MakeExample<2>(60, 0.1, seed), plane = MakeExample<3>(40, 0.1, seed);
      // Theil-Sen is biased by outliers along the last axis, the more the steeper the model.
      const double tolerance = type == std::string("theil_sen") ? 25.0 : 1.5;
      for (const Example* example : {&line, &plane}) {
        const Estimate estimate = method->Run(example->problem, seed);
        REQUIRE(estimate.status == Status::kOk);
        CHECK(AngleBetweenDegrees(estimate.model, example->truth.model) < tolerance);
        CHECK(estimate.inliers.size() == static_cast<std::size_t>(example->problem.points.rows()));
        CHECK(estimate.stats.ms_total >= estimate.stats.ms_consensus);
        CHECK(estimate.stats.ms_consensus >= 0.0);
      }
    }
  }
}

TEST_CASE("The mask is the residuals' for every classical method") {
  for (const char* type : kTypes) {
    const Example line = MakeExample<2>(80, 0.5, 3), plane = MakeExample<3>(30, 0.5, 3);
    const Estimate a = Make(type)->Run(line.problem, 1), b = Make(type)->Run(plane.problem, 1);
    CHECK(a.inliers == InlierMask<Line>(line.problem.points, a.model, 0.1));
    CHECK(b.inliers == InlierMask<Plane>(plane.problem.points, b.model, 0.1));
  }
}

TEST_CASE("Bad data gives a status from every classical method") {
  for (const char* type : kTypes) {
    CAPTURE(type);
    const auto method = Make(type);
    const auto status = [&](const PointMatrix& points) {
      return method->Run({points.cols() == 2 ? Task::kLine : Task::kPlane, points, 0.1}, 1).status;
    };
    CHECK(status(PointMatrix(0, 2)) == Status::kTooFewPoints);
    CHECK(status(PointMatrix::Zero(1, 2)) == Status::kTooFewPoints);
    CHECK(status(PointMatrix::Zero(2, 3)) == Status::kTooFewPoints);
    CHECK(status(PointMatrix::Constant(10, 2, 3.0)) == Status::kDegenerate);
    PointMatrix points = MakeExample<3>(10, 0.2, 1).problem.points;
    CHECK(status(points) == Status::kOk);
    points(4, 1) = std::numeric_limits<double>::quiet_NaN();
    CHECK(status(points) == Status::kOk);
    points.col(1).setConstant(std::numeric_limits<double>::quiet_NaN());
    CHECK(status(points) == Status::kTooFewPoints);
    PointMatrix collinear(10, 3);
    for (int i = 0; i < 10; ++i) collinear.row(i) << i, 2.0 * i, 1.0;
    CHECK(status(collinear) == Status::kDegenerate);
  }
}

TEST_CASE("Same seed, same estimate, budgets are reported") {
  const Example example = MakeExample<2>(100, 0.7, 9);
  const auto ransac = Make("ransac", "{max_iterations: 20}");
  const Estimate first = ransac->Run(example.problem, 5), second = ransac->Run(example.problem, 5);
  CHECK(first.model == second.model);
  CHECK(first.inliers == second.inliers);
  CHECK(first.stats.hypotheses == 21);
  CHECK(first.stats.unique_minimal_sets <= 20);
  bool differs = false;
  for (std::uint64_t seed = 6; seed < 12; ++seed)
    differs = differs || ransac->Run(example.problem, seed).model != first.model;
  CHECK(differs);
  CHECK(Make("exhaustive")->Run(example.problem, 1).stats.hypotheses > 4950);
  CHECK(Make("exhaustive")->Run(example.problem, 1).stats.unique_minimal_sets == 4950);
  CHECK(Make("exhaustive")->Run(example.problem, 1).model == Make("exhaustive")->Run(example.problem, 2).model);
  CHECK(Make("theil_sen")->Run(example.problem, 1).stats.hypotheses == 4950);
  CHECK(Make("theil_sen", "{max_iterations: 100}")->Run(example.problem, 1).stats.hypotheses == 100);
  CHECK(Make("lo_ransac", "{max_iterations: 20}")->Run(example.problem, 1).stats.hypotheses > 20);
}

TEST_CASE("Exhaustive search is capped where the sets are too many") {
  const Example example = MakeExample<3>(40, 0.2, 2);
  const Estimate all = Make("exhaustive")->Run(example.problem, 1);
  CHECK(all.stats.unique_minimal_sets == 9880);
  const Estimate capped = Make("exhaustive", "{max_iterations: 500}")->Run(example.problem, 1);
  CHECK(capped.status == Status::kOk);
  CHECK(capped.stats.hypotheses < 500 + 5 * 30 + 1);
}

TEST_CASE("Exhaustive search is at least as good as random search by the same score") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Example example = MakeExample<2>(60, 0.7, seed);
    const char* yaml = "{consensus: {score: msac, refit: none, final_score: msac, refit_candidates: 1}}";
    CHECK(Make("exhaustive", yaml)->Run(example.problem, seed).score >=
          Make("ransac", yaml)->Run(example.problem, seed).score);
  }
}

TEST_CASE("Options are read and checked, keys of the experiment are none of the row's") {
  CHECK(Make("theil_sen"));
  CHECK_THROWS_WITH(Make("ransac", "{label: R}"), Catch::Contains("test.yaml:1: unknown key 'label'"));
  CHECK_THROWS_WITH(Make("ransack"), Catch::Contains("unknown method type 'ransack'; did you mean 'ransac'?"));
  CHECK_THROWS_AS(Make("ransac", "{hypothesis: 20}"), Error);
  CHECK_THROWS_AS(Make("ransac", "{max_iterations: 0}"), Error);
  CHECK_THROWS_AS(Make("lo_ransac", "{consensus: {refit: best}}"), Error);
  const Config row = ResolvedRow(ConfigFromYaml("type: exhaustive"), Task::kLine, {});
  CHECK(row.Text("consensus.score") == "msac");
  CHECK(row.Text("consensus.refit") == "em");
  CHECK_THROWS_WITH(Make("exhaustive", "{}", Task::kHomography), Catch::Contains("lines and planes only"));
  ClassicalOptions none;
  none.max_iterations = 0;
  CHECK_THROWS_WITH(ClassicalEstimator(none), Catch::Contains("max_iterations"));
}

TEST_CASE("Theil-Sen: median slope and intercept of a known example") {
  // Five points on y = 2 x + 1 and one far off.
  PointMatrix points(6, 2);
  points << 0, 1, 1, 3, 2, 5, 3, 7, 4, 9, 5, 100;
  const Estimate estimate = Make("theil_sen")->Run({Task::kLine, points, 0.1}, 1);
  REQUIRE(estimate.status == Status::kOk);
  CHECK(-estimate.model[0] / estimate.model[1] == Approx(2.0));
  CHECK(-estimate.model[2] / estimate.model[1] == Approx(1.0));
  CHECK(estimate.score == 5.0);
  CHECK(estimate.model.head<2>().norm() == Approx(1.0));
}

TEST_CASE("Theil-Sen: an even number of slopes takes the middle two's mean") {
  PointMatrix points(4, 2);
  points << 0, 0, 1, 1, 2, 0, 3, 5;  // Slopes: 1, 0, 5/3, -1, 2, 5; sorted -1, 0, 1, 5/3, 2, 5.
  const Estimate estimate = Make("theil_sen")->Run({Task::kLine, points, 0.1}, 1);
  REQUIRE(estimate.status == Status::kOk);
  CHECK(-estimate.model[0] / estimate.model[1] == Approx((1.0 + 5.0 / 3.0) / 2.0));
}

TEST_CASE("Theil-Sen: pairs with equal x are left out, and a vertical line has no slope") {
  PointMatrix points(4, 2);
  points << 0, 0, 0, 5, 1, 1, 2, 2;
  CHECK(Make("theil_sen")->Run({Task::kLine, points, 0.1}, 1).status == Status::kOk);
  PointMatrix vertical(3, 2);
  vertical << 1, 0, 1, 1, 1, 2;
  CHECK(Make("theil_sen")->Run({Task::kLine, vertical, 0.1}, 1).status == Status::kNoModel);
}

TEST_CASE("Theil-Sen: a plane with outliers along z") {
  Rng rng(4);
  PointMatrix points(30, 3);
  for (int i = 0; i < 30; ++i) {
    points(i, 0) = rng.Uniform(-1, 1);
    points(i, 1) = rng.Uniform(-1, 1);
    points(i, 2) = 0.5 * points(i, 0) - 0.25 * points(i, 1) + 2.0 + (i % 10 == 0 ? 50.0 : 0.0);
  }
  const Estimate estimate = Make("theil_sen")->Run({Task::kPlane, points, 0.1}, 1);
  REQUIRE(estimate.status == Status::kOk);
  const Eigen::Vector4d expected = Eigen::Vector4d(0.5, -0.25, -1.0, 2.0) / Eigen::Vector3d(0.5, -0.25, -1.0).norm();
  CHECK(AngleBetweenDegrees(estimate.model, expected) < 1e-6);
  CHECK(Count(estimate.inliers) == 27);
}

TEST_CASE("The oracle fits the true inliers and says when it cannot") {
  const Example example = MakeExample<3>(50, 0.8, 7);
  const Estimate estimate = OracleEstimate(example.problem, example.truth);
  REQUIRE(estimate.status == Status::kOk);
  Eigen::VectorXd weights(50);
  for (int i = 0; i < 50; ++i) weights[i] = example.truth.inliers[i];
  Plane::Parameters expected;
  REQUIRE(Plane::Fit(example.problem.points, weights, &expected));
  CHECK(estimate.model == ModelParameters(expected));
  CHECK(estimate.stats.hypotheses == 1);
  CHECK(OracleEstimate(example.problem, {}).status == Status::kNoModel);
  CHECK(OracleEstimate(example.problem, {{}, {}, std::vector<std::uint8_t>(50, 0)}).status == Status::kNoModel);
  CHECK(OracleEstimate({Task::kPlane, PointMatrix(2, 3), 0.1}, {}).status == Status::kTooFewPoints);
}

}  // namespace
}  // namespace diffsac
