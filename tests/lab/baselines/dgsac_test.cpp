#include "lab/baselines/dgsac.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "lab/baselines/density_guide.h"
#include "lab/baselines/residual_density.h"
#include "ransac/all_models.h"
#include "ransac/random_problems.h"

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
  options.refit_rounds = 0;
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
      sum += EstimateDgsac<Line>(problem.points, {}, Rng(seed)).sigma;
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
    CHECK(other.sigma == Approx(scale * one.sigma));
  }
}

TEST_CASE("the one structure is selected") {
  int good = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto problem = MakeRandomProblem<2>(100, 0.3, 0.03, Rng(seed));
    const DgsacResult result = EstimateDgsac<Line>(problem.points, {}, Rng(seed));
    REQUIRE(result.status == Status::kOk);
    good += AngleBetweenDegrees(result.model, problem.truth) < 0.5 ? 1 : 0;
  }
  CAPTURE(good);
  CHECK(good >= 36);
}

TEST_CASE("sampling stops by itself once all points are explained") {
  DgsacOptions options;
  options.max_iterations = 100000;
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
    options.refit_rounds = 0;
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
  CHECK(result.sigma < 1e-10);
}

Eigen::VectorXd Densities(std::initializer_list<double> values) {
  Eigen::VectorXd result(values.size());
  std::copy(values.begin(), values.end(), result.begin());
  return result;
}

TEST_CASE("points prefer the hypotheses they are densest in, the earlier one where equal") {
  DensityGuide guide(3, 2);
  guide.Add(Densities({1.0, 5.0, 0.0}));
  guide.Add(Densities({3.0, 1.0, 0.0}));
  guide.Add(Densities({2.0, 1.0, 4.0}));
  CHECK(guide.Explanation(0) == 5.0);
  CHECK(guide.Explanation(1) == 6.0);
  CHECK(guide.Explanation(2) == 4.0);
  // Point 0: hypotheses 1 and 2; point 1: 0 and 1; point 2: 2 alone.
  CHECK(guide.Preferred() == std::vector<int>{0, 1, 2});
}

TEST_CASE("sets are drawn among points that share preferences") {
  DensityGuide guide(6, 1);
  guide.Add(Densities({9.0, 9.0, 9.0, 1.0, 1.0, 1.0}));
  guide.Add(Densities({1.0, 1.0, 1.0, 9.0, 9.0, 9.0}));
  int set[3];
  Rng rng(3);
  guide.StartRound();
  for (int i = 0; i < 50; ++i) {
    guide.Draw(1, 3, rng, set);
    CHECK(std::vector<int>(set, set + 3) == std::vector<int>{0, 1, 2});
    guide.Draw(4, 2, rng, set);
    CHECK(set[0] >= 3);
    CHECK(set[0] < set[1]);
  }
}

TEST_CASE("without correlated points the rest of a set is uniform") {
  DensityGuide guide(5, 2);
  guide.StartRound();
  Rng rng(1);
  std::set<std::vector<int>> seen;
  int set[2];
  for (int i = 0; i < 200; ++i) {
    guide.Draw(2, 2, rng, set);
    CHECK((set[0] == 2 || set[1] == 2));
    CHECK(set[0] < set[1]);
    seen.insert({set[0], set[1]});
  }
  CHECK(seen.size() == 4);
  // One correlated point only: it is taken, then any other.
  guide.Add(Densities({0.0, 0.0, 1.0, 1.0, 0.0}));
  guide.StartRound();
  int three[3];
  for (int i = 0; i < 50; ++i) {
    guide.Draw(2, 3, rng, three);
    CHECK(std::count(three, three + 3, 3) == 1);
    CHECK(std::set<int>(three, three + 3).size() == 3);
  }
}

TEST_CASE("a round's sets know nothing of what the round itself adds") {
  DensityGuide guide(10, 1);
  guide.StartRound();
  guide.Add(Densities({9, 9, 0, 0, 0, 0, 0, 0, 0, 0}));
  Rng rng(2);
  std::set<int> partners;
  int set[2];
  for (int i = 0; i < 200; ++i) {
    guide.Draw(0, 2, rng, set);
    partners.insert(set[1]);
  }
  CHECK(partners.size() == 9);
}

constexpr int kLineSize = 2;

Eigen::VectorXd TrueResiduals(const testing::HyperplaneProblem<2>& problem) {
  return RowResiduals<Line>(problem.points, problem.truth);
}

TEST_CASE("the density at a rank is the share of points that are closer, over the residual") {
  // 40 points: no smoothing (a window of one rank); 0, 0, 1, ..., 38. The first rank looked at is 2 + 3.
  Eigen::VectorXd residuals(40);
  for (int i = 0; i < 40; ++i) residuals[i] = std::max(0, 39 - i - 1);
  const ResidualDensity density = ComputeResidualDensity(residuals, kLineSize);
  REQUIRE(FirstDensityRank(40, kLineSize) == 5);
  CHECK(density.order[0] == 38);
  CHECK(density.order[1] == 39);
  CHECK(density.order[39] == 0);
  for (int k = 0; k < 40; ++k) CHECK(density.density[k] == Approx(1.0 / 40.0));
  CHECK(density.AtPoints()[0] == density.density[39]);
}

TEST_CASE("the density of many points is smoothed over their fortieth part, however large they are") {
  constexpr int kPoints = 4000, kHalf = 50;  // 50 ranks to either side, fewer at the ends.
  for (const double scale : {1.0, 1e-200, 1e300}) {
    Eigen::VectorXd residuals(kPoints);
    for (int k = 0; k < kPoints; ++k) residuals[k] = scale * std::pow((k + 1.0) / kPoints, 3);
    const ResidualDensity density = ComputeResidualDensity(residuals, kLineSize);
    for (const int k : {FirstDensityRank(kPoints, kLineSize) + 5, 1000, 2500, kPoints - 20, kPoints - 1}) {
      const int reach = std::min({kHalf, k, kPoints - 1 - k});
      double mean = 0.0;
      for (int j = k - reach; j <= k + reach; ++j) mean += residuals[j] / (2 * reach + 1);
      CAPTURE(scale, k);
      CHECK(density.density[k] * scale == Approx((k + 1 - kLineSize) / (kPoints * (mean / scale))).epsilon(1e-10));
    }
  }
}

TEST_CASE("inliers are denser than outliers, without any threshold") {
  for (double ratio : {0.2, 0.5, 0.8}) {
    int lower = 0, pairs = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const auto problem = testing::MakeRandomProblem<2>(100, ratio, 0.03, Rng(seed));
      const Eigen::VectorXd density = ComputeResidualDensity(TrueResiduals(problem), kLineSize).AtPoints();
      for (int i = 0; i < 100; ++i)
        for (int j = 0; j < 100; ++j) {
          if (!problem.inliers[i] || problem.inliers[j]) continue;
          ++pairs;
          lower += density[i] < density[j] ? 1 : 0;
        }
    }
    CAPTURE(ratio, lower, pairs);
    CHECK(lower <= 0.02 * pairs);
  }
}

TEST_CASE("evenly spread residuals have no inliers and are no structure, whatever their unit") {
  for (const double unit : {1e-3, 1.0, 1e3}) {
    Eigen::VectorXd residuals(200);
    for (int i = 0; i < 200; ++i) residuals[i] = unit * (i + 1);
    const ResidualDensity density = ComputeResidualDensity(residuals, kLineSize);
    CHECK(EstimateInlierExtent(density, kLineSize).count == 0);
    CHECK(SelectInstances({DescribeHypothesis(density, kLineSize)}, 3.0, 0.15).empty());
  }
}

TEST_CASE("the density is even up to its peak and knows no unit") {
  const auto problem = testing::MakeRandomProblem<2>(100, 0.5, 0.03, Rng(4));
  const Eigen::VectorXd residuals = TrueResiduals(problem);
  const ResidualDensity one = ComputeResidualDensity(residuals, kLineSize);
  const double peak = one.density.maxCoeff();
  CHECK(one.density[0] == peak);
  const InlierExtent extent = EstimateInlierExtent(one, kLineSize);
  // Powers of two scale exactly.
  for (double scale : {std::ldexp(1.0, 30), std::ldexp(1.0, -30)}) {
    const ResidualDensity other = ComputeResidualDensity(scale * residuals, kLineSize);
    CHECK(other.order == one.order);
    CHECK((scale * other.density - one.density).norm() <= 1e-12 * one.density.norm());
    const InlierExtent other_extent = EstimateInlierExtent(other, kLineSize);
    CHECK(other_extent.count == extent.count);
    CHECK(other_extent.residual == Approx(scale * extent.residual));
    CHECK(other_extent.evidence == Approx(extent.evidence));
  }
}

TEST_CASE("the inliers' extent is found without a threshold, for noise of any size") {
  for (double sigma : {0.01, 0.03, 0.1})
    for (double ratio : {0.1, 0.3, 0.5, 0.7}) {
      double mean = 0.0;
      constexpr int kProblems = 40;
      for (std::uint64_t seed = 0; seed < kProblems; ++seed) {
        const auto problem = testing::MakeRandomProblem<2>(200, ratio, sigma, Rng(seed));
        mean += EstimateInlierExtent(ComputeResidualDensity(TrueResiduals(problem), kLineSize), kLineSize).residual;
      }
      mean /= kProblems;
      CAPTURE(sigma, ratio, mean);
      CHECK(mean > 1.8 * sigma);
      CHECK(mean < 4.5 * sigma);
    }
}

TEST_CASE("hostile residuals give densities that are numbers, or none") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  CHECK(ComputeResidualDensity(Eigen::VectorXd::Constant(10, nan), kLineSize).density.size() == 0);
  CHECK(ComputeResidualDensity(Eigen::VectorXd::Zero(0), kLineSize).density.size() == 0);
  CHECK(ComputeResidualDensity(Eigen::VectorXd::Zero(2), kLineSize).density.size() == 0);
  CHECK(EstimateInlierExtent({}, kLineSize).count == 0);
  const ResidualDensity zero = ComputeResidualDensity(Eigen::VectorXd::Zero(10), kLineSize);
  CHECK(zero.density.allFinite());
  Eigen::VectorXd mixed(12);
  mixed << 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, nan, infinite;
  const ResidualDensity density = ComputeResidualDensity(mixed, kLineSize);
  CHECK(density.density.allFinite());
  CHECK(density.residuals[11] == 2.0);
  CHECK(EstimateInlierExtent(density, kLineSize).count == 8);
  for (double scale : {1e-300, 1e300}) CHECK(ComputeResidualDensity(scale * mixed, kLineSize).residuals.allFinite());
}

/// 60 points of one line, 40 of another, 40 anywhere.
struct TwoLines {
  PointMatrix points{140, 2};
  Line::Parameters first, second;
  explicit TwoLines(std::uint64_t seed) {
    const auto one = testing::MakeRandomProblem<2>(100, 0.4, 0.03, Rng(seed).Fork("one"));
    const auto other = testing::MakeRandomProblem<2>(40, 0.0, 0.03, Rng(seed).Fork("other"));
    points << one.points, other.points;
    first = one.truth;
    second = other.truth;
  }
  DensityHypothesis Describe(const Line::Parameters& model) const {
    return DescribeHypothesis(ComputeResidualDensity(RowResiduals<Line>(points, model), 2), 2);
  }
};

TEST_CASE("top lists: 1 for equal, 0 for disjoint, the footrule between") {
  const std::vector<int> a{0, 1, 2, 3, 4, 5};
  CHECK(TopListCorrelation(a, a, 6) == 1.0);
  CHECK(TopListCorrelation(a, {3, 4, 5, 0, 1, 2}, 3) == 0.0);
  CHECK(TopListCorrelation(a, a, 0) == 0.0);
  // {0, 1} and {1, 5}: 0 is absent from the second (place 3: |3 − 1|), 1 moves by one, 5 is absent from the first (1).
  CHECK(TopListCorrelation(a, {1, 5, 0, 2, 3, 4}, 2) == Approx(1.0 - 4.0 / 6.0));
  CHECK(TopListCorrelation({1, 5, 0, 2, 3, 4}, a, 2) == Approx(1.0 - 4.0 / 6.0));
}

TEST_CASE("two structures give two hypotheses, however many stand for each") {
  int right = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const TwoLines lines(seed);
    std::vector<DensityHypothesis> hypotheses;
    for (int i = 0; i < 4; ++i) {
      Line::Parameters shift(0.0, 0.0, 0.004 * i);
      hypotheses.push_back(lines.Describe(lines.first + shift));
      hypotheses.push_back(lines.Describe(lines.second + shift));
    }
    const std::vector<int> selected = SelectInstances(hypotheses, 3.0, 0.15);
    right += selected.size() == 2 && selected[0] % 2 != selected[1] % 2 ? 1 : 0;
  }
  CAPTURE(right);
  CHECK(right >= 27);
}

TEST_CASE("a hypothesis has its inliers' part of the area under its density") {
  const TwoLines lines(3);
  const Eigen::VectorXd residuals = RowResiduals<Line>(lines.points, lines.first);
  const ResidualDensity density = ComputeResidualDensity(residuals, 2);
  const DensityHypothesis hypothesis = DescribeHypothesis(density, 2);
  const auto area = [&](Eigen::Index count) {
    const auto heights = density.density.head(count - 1) + density.density.segment(1, count - 1);
    const auto widths = density.residuals.segment(1, count - 1) - density.residuals.head(count - 1);
    return 0.5 * heights.dot(widths);
  };
  REQUIRE(hypothesis.inliers.count > 20);
  CHECK(hypothesis.area_share == Approx(area(hypothesis.inliers.count) / area(residuals.size())));
  CHECK(hypothesis.mean_residual == Approx(density.residuals.head(hypothesis.inliers.count).mean()));
}

}  // namespace
}  // namespace diffsac
