#include "diffsac/ransac/scores/mixture.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/geometry/hyperplane.h"
#include "ransac/random_problems.h"

namespace diffsac {
namespace {

double LogLikelihoodRatio(const Mixture& mixture, const Eigen::VectorXd& residuals, double share) {
  double sum = 0.0;
  for (double r : residuals)
    sum += std::log(1.0 - share +
                    share * mixture.density_ratio * std::exp(-0.5 * r * r / (mixture.sigma * mixture.sigma)));
  return sum;
}

Eigen::VectorXd MixedResiduals(int inliers, int outliers, double sigma, Rng& rng) {
  Eigen::VectorXd residuals(inliers + outliers);
  for (int i = 0; i < inliers; ++i) residuals[i] = std::abs(sigma * rng.Normal());
  for (int i = 0; i < outliers; ++i) residuals[inliers + i] = rng.Uniform(0.0, 5.0);
  return residuals;
}

TEST_CASE("The density ratio of matches follows from their bounding box") {
  PointMatrix points(3, 4);
  points << 0, 0, 0, 0, 10, 2.5, 2.5, 10, 4, 1, 1, 4;
  const Mixture mixture = MakeMixture(points, 0.1, 0.03);
  CHECK(mixture.density_ratio == Approx(5.0 / (std::sqrt(2.0 * 3.14159265358979) * 0.03)));
  CHECK(mixture.Odds(0.5) == Approx(mixture.density_ratio));
  CHECK(mixture.Odds(0.2) == Approx(mixture.density_ratio / 4.0));
  // A flat box counts as 2 ε high, and the ratio has a floor.
  points.rightCols(3).setZero();
  CHECK(MakeMixture(points, 0.1, 0.03).density_ratio ==
        Approx(std::pow(10.0 * 0.2 * 0.2 * 0.2, 0.25) / (std::sqrt(2.0 * 3.14159265358979) * 0.03)));
  CHECK(MakeMixture(points, 0.1, 100.0).density_ratio == 2.0);
}

TEST_CASE("The density ratio of points is that of the box that uniform ones fill, however it is turned") {
  PointMatrix points(50 * 20, 2);
  for (int i = 0; i < 1000; ++i) points.row(i) << 0.2 * (i % 50 + 0.5), 0.125 * (i / 50 + 0.5);
  const double expected = std::sqrt(10.0 * 2.5) / (std::sqrt(2.0 * 3.14159265358979) * 0.03);
  for (const double angle : {0.0, 0.3, 0.8, 1.5}) {
    Eigen::Matrix2d turn;
    turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    const PointMatrix turned = points * turn.transpose();
    CHECK(MakeMixture(turned, 0.1, 0.03).density_ratio == Approx(expected).epsilon(0.002));
    CHECK(MakeMixture(turned, 0.1, 0.03).density_ratio == Approx(MakeMixture(points, 0.1, 0.03).density_ratio));
  }
  // All on one line: 2 ε high.
  points.col(1) = 0.5 * points.col(0);
  CHECK(MakeMixture(points, 0.1, 0.03).density_ratio ==
        Approx(std::sqrt(std::sqrt(125.0) * 0.2) / (std::sqrt(2.0 * 3.14159265358979) * 0.03)).epsilon(0.002));
}

TEST_CASE("The mixture score lies in [0, N] and rises as residuals fall") {
  Rng rng(2);
  const Mixture mixture{0.05, 40.0};
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::VectorXd residuals = MixedResiduals(10, 30, 0.05, rng);
    const double score = MixtureScore(mixture, residuals);
    CHECK(score >= 0.0);
    CHECK(score <= 40.0);
    CHECK(MixtureScore(mixture, 0.8 * residuals) >= score - 1e-6);
    // Of the share of inliers that makes the residuals likeliest.
    double most = 0.0;
    for (double share = 0.0005; share < 1.0; share += 0.0005)
      most = std::max(most, LogLikelihoodRatio(mixture, residuals, share) / std::log(mixture.density_ratio));
    CHECK(score == Approx(most).epsilon(1e-3).margin(1e-3));
  }
  CHECK(MixtureScore(mixture, Eigen::VectorXd::Zero(10)) == Approx(10.0).epsilon(1e-3));
  CHECK(MixtureScore(mixture, Eigen::VectorXd::Constant(10, 5.0)) == Approx(0.0).margin(1e-12));
  CHECK(MixtureScore(mixture, Eigen::VectorXd(0)) == 0.0);
}

TEST_CASE("Residuals that are not finite count as infinitely far") {
  const Mixture mixture{0.1, 20.0};
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  Eigen::VectorXd far(6), broken(6);
  far << 0.0, 0.05, 0.1, 0.02, 1e3, 1e3;
  broken << 0.0, 0.05, 0.1, 0.02, nan, infinity;
  CHECK(MixtureScore(mixture, broken) == Approx(MixtureScore(mixture, far)));
  CHECK(DensityRatios(mixture, broken)[4] == 0.0);
  CHECK(MixtureScore(mixture, Eigen::VectorXd::Constant(3, nan)) == Approx(0.0).margin(1e-3));
}

TEMPLATE_TEST_CASE_SIG("A mixture refit never lowers the mixture's likelihood", "", ((int D), D), 2, 3) {
  using Model = Hyperplane<D>;
  for (int trial = 0; trial < 200; ++trial) {
    const auto problem = testing::MakeRandomProblem<D>(80, 0.5, 0.04, Rng(100 + trial));
    const Mixture mixture = MakeMixture(problem.points, 0.12, 0.04);
    typename Model::Parameters model = problem.truth;
    for (double& value : model) value += 0.02 * Rng(trial).Fork("shift").Normal();
    model /= model.template head<D>().norm();
    const auto score = [&] {
      Eigen::VectorXd residuals(80);
      for (int i = 0; i < 80; ++i) residuals[i] = Model::Residual(model, problem.points.data() + i * D);
      return MixtureScore(mixture, residuals);
    };
    const double before = score();
    const int fits = MixtureRefit<Model>(problem.points, mixture, 0.5, &model);
    CHECK(fits >= 1);
    CHECK(fits <= 30);
    CHECK(score() >= before - 1e-3);
  }
}

TEST_CASE("A refit without any point near keeps a finite model") {
  PointMatrix points(4, 2);
  points << 0, 0, 1, 0, 0, 1, 1, 1;
  Line::Parameters model(1.0, 0.0, 1e6);
  for (double sigma_prior : {kSigmaKnown, 1.0}) {
    MixtureRefit<Line>(points, {1e-3, 100.0}, 0.0, &model, sigma_prior);
    CHECK(model.allFinite());
  }
}

TEST_CASE("Another sigma scales the density ratio") {
  const Mixture mixture{0.05, 40.0};
  CHECK(mixture.WithSigma(0.1).sigma == 0.1);
  CHECK(mixture.WithSigma(0.1).density_ratio == Approx(20.0));
  CHECK(mixture.WithSigma(100.0).density_ratio == 2.0);
}

TEST_CASE("A prior on sigma that outweighs every point is a known sigma") {
  for (int trial = 0; trial < 50; ++trial) {
    const auto problem = testing::MakeRandomProblem<2>(80, 0.5, 0.08, Rng(200 + trial));
    const Mixture mixture = MakeMixture(problem.points, 0.12, 0.04);
    Line::Parameters known = problem.truth, outweighed = problem.truth, estimated = problem.truth;
    MixtureRefit<Line>(problem.points, mixture, 0.5, &known);
    MixtureRefit<Line>(problem.points, mixture, 0.5, &outweighed, 1e9);
    const int fits = MixtureRefit<Line>(problem.points, mixture, 0.5, &estimated, 5.0);
    CHECK(AngleBetweenDegrees(known, outweighed) < 0.1);  // the iterations stop at other rounds
    CHECK(AngleBetweenDegrees(known, estimated) > 0.0);
    CHECK(fits <= 100);
  }
}

}  // namespace
}  // namespace diffsac
