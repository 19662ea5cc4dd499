#include "diffsac/consensus/structures/dgsac.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "consensus/all_models.h"

namespace diffsac {
namespace {

using testing::MakeModelProblem;
using testing::MakeRandomProblem;
using testing::ModelProblem;

template <MinimalModel Model>
double ShareAllInlier(const DgsacResult& result, int outliers, int begin, int end) {
  int good = 0;
  for (int s = begin; s < end; ++s) {
    const int* set = result.sets.data() + static_cast<std::ptrdiff_t>(s) * Model::kMinimalSize;
    good += std::all_of(set, set + Model::kMinimalSize, [&](int i) { return i >= outliers; }) ? 1 : 0;
  }
  return static_cast<double>(good) / std::max(1, end - begin);
}

TEMPLATE_TEST_CASE("guided sets are all-inlier more often than uniform ones", "", Line, Plane, Homography, Fundamental,
                   Essential, AbsolutePose) {
  DgsacOptions options;
  options.max_iterations = 400;
  options.stopping = DgsacStopping::kBudget;
  options.refit = DgsacRefit::kNone;
  double guided = 0.0, uniform = 0.0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const ModelProblem problem = MakeModelProblem<TestType>(100, 0.5, Rng(seed));
    const DgsacResult result = EstimateDgsac<TestType>(problem.points, options, Rng(seed));
    const int sets = static_cast<int>(result.sets.size()) / TestType::kMinimalSize;
    REQUIRE(sets == 400);
    REQUIRE(result.guided_from == 100);
    uniform += ShareAllInlier<TestType>(result, problem.outliers, 0, result.guided_from);
    guided += ShareAllInlier<TestType>(result, problem.outliers, result.guided_from, sets);
  }
  CAPTURE(guided / 8, uniform / 8);
  CHECK(guided > 1.5 * uniform);
}

TEMPLATE_TEST_CASE("every model is found among 40 % outliers without a threshold", "", Line, Plane, Homography,
                   Fundamental, Essential, AbsolutePose) {
  int good = 0;
  constexpr int kProblems = 10;
  for (std::uint64_t seed = 0; seed < kProblems; ++seed) {
    const ModelProblem problem = MakeModelProblem<TestType>(200, 0.4, Rng(seed));
    const DgsacResult result = EstimateDgsac<TestType>(problem.points, {}, Rng(seed));
    REQUIRE(result.status == Status::kOk);
    int found = 0, wrong = 0;
    for (int i = 0; i < 200; ++i) (i < problem.outliers ? wrong : found) += result.inliers[i];
    good += found >= 96 && wrong <= 20 ? 1 : 0;
  }
  CAPTURE(good);
  CHECK(good >= 8);
}

TEST_CASE("the noise scale is estimated, whatever it is") {
  for (double sigma : {0.01, 0.03, 0.1}) {
    double sum = 0.0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const auto problem = MakeRandomProblem<2>(100, 0.5, sigma, Rng(seed));
      sum += EstimateDgsac<Line>(problem.points, {}, Rng(seed)).noise_scale;
    }
    CAPTURE(sigma, sum / 20);
    CHECK(sum / 20 > 0.7 * sigma);
    CHECK(sum / 20 < 1.4 * sigma);
  }
}

TEST_CASE("the estimate does not depend on the unit") {
  const auto problem = MakeRandomProblem<2>(100, 0.5, 0.03, Rng(3));
  const DgsacResult one = EstimateDgsac<Line>(problem.points, {}, Rng(1));
  for (double scale : {std::ldexp(1.0, 27), std::ldexp(1.0, -27)}) {
    const DgsacResult other = EstimateDgsac<Line>(scale * problem.points, {}, Rng(1));
    CHECK(other.sets == one.sets);
    CHECK(other.inliers == one.inliers);
    CHECK(other.noise_scale == Approx(scale * one.noise_scale));
  }
}

TEST_CASE("the one structure is selected, by each way of choosing") {
  for (const auto& [choose, name] : kEnumNames<DgsacChoice>) {
    DgsacOptions options;
    options.choose = choose;
    int good = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const auto problem = MakeRandomProblem<2>(100, 0.3, 0.03, Rng(seed));
      const DgsacResult result = EstimateDgsac<Line>(problem.points, options, Rng(seed));
      REQUIRE(result.status == Status::kOk);
      good += AngleBetweenDegrees(result.model, problem.truth) < 0.5 ? 1 : 0;
    }
    CAPTURE(name, good);
    CHECK(good >= 36);
  }
}

TEST_CASE("the largest of two structures is chosen by the number of points") {
  DgsacOptions options;
  options.choose = DgsacChoice::kLargest;
  int good = 0, two = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto one = MakeRandomProblem<2>(80, 0.1, 0.03, Rng(seed).Fork("one"));
    const auto other = MakeRandomProblem<2>(30, 0.0, 0.02, Rng(seed).Fork("other"));
    PointMatrix points(110, 2);
    points << one.points, other.points;
    const DgsacResult result = EstimateDgsac<Line>(points, options, Rng(seed));
    REQUIRE(result.status == Status::kOk);
    good += AngleBetweenDegrees(result.model, one.truth) < 1.0 ? 1 : 0;
    two += result.structures >= 2 ? 1 : 0;
  }
  CAPTURE(good, two);
  CHECK(good >= 16);
  CHECK(two >= 16);
}

TEST_CASE("sampling stops by itself once all points are explained") {
  DgsacOptions options;
  options.max_iterations = 100000;
  options.round_size = 1000;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto problem = MakeRandomProblem<2>(100, 0.5, 0.03, Rng(seed));
    const DgsacResult result = EstimateDgsac<Line>(problem.points, options, Rng(seed));
    CHECK(result.stop == StopReason::kConfidence);
    CHECK(result.sets.size() / 2 < 5000);
    CHECK(result.guided_from == 100);
  }
}

TEST_CASE("a budget is kept to the set") {
  const auto problem = MakeRandomProblem<2>(100, 0.5, 0.03, Rng(1));
  for (int hypotheses : {1, 2, 7, 20, 333}) {
    DgsacOptions options;
    options.max_iterations = hypotheses;
    options.stopping = DgsacStopping::kBudget;
    options.refit = DgsacRefit::kNone;
    const DgsacResult result = EstimateDgsac<Line>(problem.points, options, Rng(2));
    CHECK(static_cast<int>(result.sets.size()) == 2 * hypotheses);
    CHECK(result.hypotheses == hypotheses);
    CHECK(result.stop == StopReason::kBudget);
    CHECK(static_cast<int>(result.first_sets.size()) == std::min(hypotheses, kReportedSets));
    CHECK(result.unique_minimal_sets <= hypotheses);
  }
}

TEST_CASE("the same numbers give the same estimate, another stream other sets") {
  const auto problem = MakeRandomProblem<3>(100, 0.5, 0.03, Rng(1));
  const DgsacResult a = EstimateDgsac<Plane>(problem.points, {}, Rng(5));
  const DgsacResult b = EstimateDgsac<Plane>(problem.points, {}, Rng(5));
  CHECK(a.model == b.model);
  CHECK(a.sets == b.sets);
  CHECK(a.inliers == b.inliers);
  CHECK(EstimateDgsac<Plane>(problem.points, {}, Rng(6)).sets != a.sets);
}

TEMPLATE_TEST_CASE("hostile points get a status", "", Line, Plane, Homography, Fundamental, Essential, AbsolutePose) {
  DgsacOptions options;
  options.max_iterations = 50;
  const ModelProblem whole = MakeModelProblem<TestType>(40, 0.3, Rng(1));
  for (int count : {0, 1, TestType::kMinimalSize - 1}) {
    const PointMatrix points = whole.points.topRows(count);
    CHECK(EstimateDgsac<TestType>(points, options, Rng(1)).status == Status::kTooFewPoints);
  }
  // As many points as a set has: they fit whatever they are, and there is nothing to tell a density from.
  const PointMatrix minimal = whole.points.topRows(TestType::kMinimalSize);
  CHECK(EstimateDgsac<TestType>(minimal, options, Rng(1)).status == Status::kNoModel);
  for (int more : {1, 2, 3}) {
    const PointMatrix few = whole.points.topRows(TestType::kMinimalSize + more);
    const DgsacResult result = EstimateDgsac<TestType>(few, options, Rng(1));
    if (result.status == Status::kOk) CHECK(result.model.allFinite());
  }
  PointMatrix equal = whole.points;
  equal.rowwise() = Eigen::RowVectorXd(whole.points.row(0));
  CHECK(EstimateDgsac<TestType>(equal, options, Rng(1)).status != Status::kOk);
  PointMatrix invalid = whole.points;
  invalid(3, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK(EstimateDgsac<TestType>(invalid, options, Rng(1)).status == Status::kDegenerate);
  for (double scale : {1e-8, 1e8}) {
    const DgsacResult result = EstimateDgsac<TestType>(scale * whole.points, options, Rng(1));
    if (result.status == Status::kOk) CHECK(result.model.allFinite());
  }
}

TEST_CASE("more points than orders can be kept of are refused") {
  const auto problem = MakeRandomProblem<2>(kMostDgsacPoints + 1, 0.3, 0.03, Rng(3));
  CHECK(EstimateDgsac<Line>(problem.points, {}, Rng(1)).status == Status::kTooManyPoints);
}

TEST_CASE("points exactly on a line are found, with a scale of rounding's size") {
  auto problem = MakeRandomProblem<2>(60, 0.5, 0.0, Rng(2));
  const DgsacResult result = EstimateDgsac<Line>(problem.points, {}, Rng(1));
  REQUIRE(result.status == Status::kOk);
  CHECK(AngleBetweenDegrees(result.model, problem.truth) < 1e-6);
  CHECK(result.noise_scale < 1e-10);
}

}  // namespace
}  // namespace diffsac
