#include "diffsac/consensus/samplers/density_selection.h"

#include <catch2/catch.hpp>
#include <numeric>

#include "consensus/random_problems.h"

namespace diffsac {
namespace {

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
    Eigen::VectorXd residuals(points.rows());
    for (Eigen::Index i = 0; i < points.rows(); ++i) residuals[i] = Line::Residual(model, points.data() + 2 * i);
    return DescribeHypothesis(ComputeResidualDensity(residuals, 2), 2);
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
    const std::vector<int> selected = SelectStructures(hypotheses, 3.0, 0.15);
    right += selected.size() == 2 && selected[0] % 2 != selected[1] % 2 ? 1 : 0;
  }
  CAPTURE(right);
  CHECK(right >= 27);
}

TEST_CASE("a hypothesis has its inliers' part of the area under its density") {
  const TwoLines lines(3);
  Eigen::VectorXd residuals(lines.points.rows());
  for (Eigen::Index i = 0; i < residuals.size(); ++i)
    residuals[i] = Line::Residual(lines.first, lines.points.data() + 2 * i);
  const ResidualDensity density = ComputeResidualDensity(residuals, 2);
  const DensityHypothesis hypothesis = DescribeHypothesis(density, 2);
  const auto area = [&](Eigen::Index count) {
    const auto heights = density.density.head(count - 1) + density.density.segment(1, count - 1);
    const auto widths = density.residuals.segment(1, count - 1) - density.residuals.head(count - 1);
    return 0.5 * heights.dot(widths);
  };
  REQUIRE(hypothesis.inliers.count > 20);
  CHECK(hypothesis.area_share == Approx(area(hypothesis.inliers.count) / area(residuals.size())));
  CHECK((hypothesis.share * area(residuals.size())).isApprox(density.AtPoints(), 1e-12));
  CHECK(hypothesis.mean_residual == Approx(density.residuals.head(hypothesis.inliers.count).mean()));
}

TEST_CASE("points go to the structure they lie on") {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const TwoLines lines(seed);
    const std::vector<DensityHypothesis> hypotheses = {lines.Describe(lines.first), lines.Describe(lines.second)};
    const std::vector<int> owner = AssignPoints(hypotheses, {0, 1});
    int first = 0, second = 0;
    for (int i = 40; i < 100; ++i) first += owner[i] == 0 ? 1 : 0;
    for (int i = 100; i < 140; ++i) second += owner[i] == 1 ? 1 : 0;
    CAPTURE(seed);
    CHECK(first >= 48);
    CHECK(second >= 32);
  }
  CHECK(AssignPoints({}, {}).empty());
}

TEST_CASE("a flat density is no structure") {
  Eigen::VectorXd even(100);
  std::iota(even.begin(), even.end(), 1.0);
  const std::vector<DensityHypothesis> flat = {DescribeHypothesis(ComputeResidualDensity(even, 2), 2)};
  CHECK(SelectStructures(flat, 3.0, 0.15).empty());
  CHECK(SelectStructures({}, 3.0, 0.15).empty());
}

}  // namespace
}  // namespace diffsac
