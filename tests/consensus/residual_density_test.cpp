#include "diffsac/consensus/scores/residual_density.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "consensus/random_problems.h"

namespace diffsac {
namespace {

constexpr int kLineSize = 2;

Eigen::VectorXd TrueResiduals(const testing::HyperplaneProblem<2>& problem) {
  Eigen::VectorXd residuals(problem.points.rows());
  for (Eigen::Index i = 0; i < residuals.size(); ++i)
    residuals[i] = Line::Residual(problem.truth, problem.points.data() + 2 * i);
  return residuals;
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

TEST_CASE("a wrong model's density is lower at the inliers than the right one's") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto problem = testing::MakeRandomProblem<2>(100, 0.5, 0.03, Rng(seed));
    auto turned = problem;
    const Eigen::Vector2d normal = problem.truth.head<2>();
    turned.truth.head<2>() << -normal[1], normal[0];
    const Eigen::VectorXd right = ComputeResidualDensity(TrueResiduals(problem), kLineSize).AtPoints();
    const Eigen::VectorXd wrong = ComputeResidualDensity(TrueResiduals(turned), kLineSize).AtPoints();
    int higher = 0, inliers = 0;
    for (int i = 0; i < 100; ++i) {
      inliers += problem.inliers[i];
      higher += problem.inliers[i] && right[i] > wrong[i] ? 1 : 0;
    }
    CHECK(higher >= 0.9 * inliers);
  }
}

TEST_CASE("evenly spread residuals have no inliers, whatever their unit") {
  for (const double unit : {1e-3, 1.0, 1e3}) {
    Eigen::VectorXd residuals(200);
    for (int i = 0; i < 200; ++i) residuals[i] = unit * (i + 1);
    CHECK(EstimateInlierExtent(ComputeResidualDensity(residuals, kLineSize), kLineSize).count == 0);
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

TEST_CASE("residuals without an end of inliers have a low contrast") {
  Eigen::VectorXd even(200);
  for (int i = 0; i < 200; ++i) even[i] = 1.0 + i;
  CHECK(EstimateInlierExtent(ComputeResidualDensity(even, kLineSize), kLineSize).contrast < 1.5);
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

}  // namespace
}  // namespace diffsac
