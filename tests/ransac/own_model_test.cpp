// A program's own model through ransac::Search: a circle, with as much of it left out as may be.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "diffsac/ransac/search.h"

namespace diffsac::ransac {
namespace {

/// Of three points in the plane.
struct BareCircle {
  using Parameters = Eigen::Vector3d;  // x, y, radius
  static constexpr int kDimension = 2;
  static constexpr int kMinimalSize = 3;
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    const Eigen::RowVector2d a = points.row(set[0]), b = points.row(set[1]) - a, c = points.row(set[2]) - a;
    const double twice_area = 2.0 * (b[0] * c[1] - b[1] * c[0]);
    if (std::abs(twice_area) < 1e-9) return 0;
    const double bb = b.squaredNorm(), cc = c.squaredNorm();
    const Eigen::RowVector2d centre((c[1] * bb - b[1] * cc) / twice_area, (b[0] * cc - c[0] * bb) / twice_area);
    *out << (a + centre).transpose(), centre.norm();
    return 1;
  }
  static double Residual(const Parameters& circle, const double* point) {
    return std::abs(std::hypot(point[0] - circle[0], point[1] - circle[1]) - circle[2]);
  }
};

/// Fitted by the derivatives of its residual.
struct FreeCircle : BareCircle {
  static constexpr bool kFreeParameters = true;
};

/// Fitted by the linear equations of x² + y² = 2 x cx + 2 y cy + d.
struct LinearCircle : BareCircle {
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const Eigen::Vector3d row(2.0 * points(i, 0), 2.0 * points(i, 1), 1.0);
      normal += weights[i] * row * row.transpose();
      right += weights[i] * points.row(i).squaredNorm() * row;
    }
    const Eigen::Vector3d x = normal.ldlt().solve(right);
    *out << x[0], x[1], std::sqrt(x[2] + x[0] * x[0] + x[1] * x[1]);
    return out->allFinite();
  }
};

const Eigen::Vector3d kTruth(40.0, 55.0, 25.0);
constexpr double kSigma = 0.3;

/// Points on the true circle first, then points anywhere in a square of side 100.
PointMatrix MakePoints(int count, double outlier_ratio, std::uint64_t seed) {
  Rng rng(seed);
  const int inliers = static_cast<int>(std::lround(count * (1.0 - outlier_ratio)));
  PointMatrix points(count, 2);
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * rng.Uniform(), radius = kTruth[2] + kSigma * rng.Normal();
    points.row(i) << kTruth[0] + radius * std::cos(angle), kTruth[1] + radius * std::sin(angle);
    if (i >= inliers) points.row(i) << 100.0 * rng.Uniform(), 100.0 * rng.Uniform();
  }
  return points;
}

double ErrorOf(const Eigen::Vector3d& circle) { return (circle - kTruth).cwiseAbs().maxCoeff(); }

template <class M>
double WorstOfTen(double outlier_ratio) {
  double worst = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto found = Search<M>(MakePoints(300, outlier_ratio, seed), {.max_residual = 2.0, .seed = seed});
    REQUIRE(found.ok());
    worst = std::max(worst, ErrorOf(found.model));
    CHECK(found.log10_nfa < -4.0);
    if constexpr (Completed<M>::kFits) CHECK(found.sigma == Approx(kSigma).epsilon(0.5));
  }
  return worst;
}

TEST_CASE("An own model recovers the truth") {
  for (const double outlier_ratio : {0.5, 0.8}) {
    CAPTURE(outlier_ratio);
    CHECK(WorstOfTen<LinearCircle>(outlier_ratio) < 0.35);
    CHECK(WorstOfTen<FreeCircle>(outlier_ratio) < 0.35);
    CHECK(WorstOfTen<BareCircle>(outlier_ratio) < 2.0);
  }
}

TEST_CASE("Exact points give an exact own model") {
  PointMatrix points(30, 2);
  for (int i = 0; i < 30; ++i)
    points.row(i) << kTruth[0] + kTruth[2] * std::cos(i), kTruth[1] + kTruth[2] * std::sin(i);
  CHECK(ErrorOf(Search<LinearCircle>(points, {.max_residual = 2.0}).model) < 1e-9);
  CHECK(ErrorOf(Search<FreeCircle>(points, {.max_residual = 2.0}).model) < 1e-6);
  CHECK(ErrorOf(Search<BareCircle>(points, {.max_residual = 2.0}).model) < 1e-6);
}

TEST_CASE("Threads change nothing of an own model") {
  for (const double outlier_ratio : {0.3, 0.8}) {
    const PointMatrix points = MakePoints(500, outlier_ratio, 5);
    const auto one = Search<FreeCircle>(points, {.max_residual = 2.0, .num_threads = 1, .seed = 3});
    const auto four = Search<FreeCircle>(points, {.max_residual = 2.0, .num_threads = 4, .seed = 3});
    CHECK(one.model == four.model);
    CHECK(one.inliers == four.inliers);
    CHECK(one.log10_nfa == four.log10_nfa);
    CHECK(one.iterations == four.iterations);
  }
}

TEST_CASE("Seeds decide what an own model draws") {
  const PointMatrix points = MakePoints(400, 0.8, 7);
  const auto run = [&](std::uint64_t seed) { return Search<BareCircle>(points, {.max_residual = 2.0, .seed = seed}); };
  CHECK(run(1).model == run(1).model);
  CHECK(run(1).model != run(2).model);
}

TEST_CASE("The order of points is no matter") {
  const PointMatrix points = MakePoints(300, 0.6, 9);
  const std::vector<int> order = Rng(4).Permutation(300);
  const PointMatrix permuted = points(order, Eigen::all);
  const auto first = Search<LinearCircle>(points, {.max_residual = 2.0});
  const auto second = Search<LinearCircle>(permuted, {.max_residual = 2.0});
  CHECK((first.model - second.model).norm() < 0.1);
  int same = 0;
  for (int i = 0; i < 300; ++i) same += first.inliers[order[i]] == second.inliers[i];
  CHECK(same >= 290);
}

TEST_CASE("Too few points have no own model") {
  const PointMatrix points = MakePoints(3, 0.0, 1);
  for (int count : {0, 1, 2}) {
    const auto found = Search<LinearCircle>(points.topRows(count), {.max_residual = 2.0});
    CHECK(found.status == Status::kTooFewPoints);
    CHECK(found.inliers == std::vector<std::uint8_t>(count, 0));
    CHECK(std::isinf(found.log10_nfa));
  }
  const auto found = Search<LinearCircle>(points, {.max_residual = 2.0});
  CHECK(found.ok());
  CHECK(found.iterations == 1);
  CHECK(std::isinf(found.log10_nfa));
  CHECK_FALSE(Search<LinearCircle>(PointMatrix::Ones(20, 2), {.max_residual = 2.0}).ok());
}

TEST_CASE("Rows that are not finite are left out") {
  const PointMatrix points = MakePoints(200, 0.5, 11);
  const auto clean = Search<LinearCircle>(points, {.max_residual = 2.0});
  PointMatrix some(202, 2);
  some << std::nan(""), 1.0, points, 1.0, std::numeric_limits<double>::infinity();
  const auto found = Search<LinearCircle>(some, {.max_residual = 2.0});
  CHECK(found.model == clean.model);
  CHECK(found.num_nonfinite == 2);
  CHECK(found.num_inliers == clean.num_inliers);
  CHECK(found.inliers.front() == 0);
  CHECK(found.inliers.back() == 0);
  CHECK(std::equal(clean.inliers.begin(), clean.inliers.end(), found.inliers.begin() + 1));
  const PointMatrix none = PointMatrix::Constant(9, 2, std::nan(""));
  CHECK(Search<LinearCircle>(none, {.max_residual = 2.0}).status == Status::kTooFewPoints);
}

TEST_CASE("Points without structure may be chance") {
  int chance = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    chance += Search<FreeCircle>(MakePoints(100, 1.0, seed), {.max_residual = 2.0, .seed = seed}).log10_nfa > 0.0;
  CHECK(chance >= 19);
}

TEST_CASE("Guidance saves draws and finds what is rare") {
  std::int64_t alike = 0, guided = 0, weighted = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const PointMatrix points = MakePoints(400, 0.9, seed);
    Eigen::VectorXd good = Eigen::VectorXd::Constant(400, 0.1);
    good.head(40).setConstant(0.8);
    const Options options{.max_residual = 2.0, .max_iterations = 20000, .min_iterations = 0, .seed = seed};
    alike += Search<FreeCircle>(points, options).iterations;
    const auto by_prior = Search<FreeCircle>(points, options, {.inlier_probabilities = good});
    const auto by_weight = Search<FreeCircle>(points, options, {.draw_weights = 100.0 * good});
    CHECK(ErrorOf(by_prior.model) < 0.6);
    CHECK(ErrorOf(by_weight.model) < 0.6);
    guided += by_prior.iterations;
    weighted += by_weight.iterations;
  }
  CHECK(guided * 4 < alike);
  CHECK(weighted * 4 < alike);
}

TEST_CASE("an initial model counts as one found") {
  const PointMatrix points = MakePoints(400, 0.9, 3);
  const Options options{.max_residual = 2.0, .max_iterations = 1, .min_iterations = 0, .initial_model = kTruth};
  CHECK(ErrorOf(Search<FreeCircle>(points, options).model) < 0.5);
}

TEST_CASE("Mistakes in arguments of an own model throw") {
  const PointMatrix points = MakePoints(20, 0.0, 1);
  const auto search = [&](const Options& options, const PointGuidance& guidance = {}) {
    return Search<LinearCircle>(points, options, guidance);
  };
  CHECK_THROWS_AS(search({}), std::invalid_argument);
  CHECK_THROWS_AS(search({.max_residual = -1.0}), std::invalid_argument);
  CHECK_THROWS_AS(search({.max_residual = 1.0, .min_residual = 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(search({.max_residual = 1.0, .max_iterations = 0}), std::invalid_argument);
  CHECK_THROWS_AS(search({.max_residual = 1.0, .confidence = 1.0}), std::invalid_argument);
  CHECK_THROWS_AS(search({.max_residual = 1.0, .num_threads = -1}), std::invalid_argument);
  CHECK_THROWS_AS(search({.max_residual = 1.0, .initial_model = Eigen::VectorXd::Ones(4)}), std::invalid_argument);
  CHECK_THROWS_AS(search({.max_residual = 1.0}, {.draw_weights = Eigen::VectorXd::Ones(3)}), std::invalid_argument);
  CHECK_THROWS_AS(search({.max_residual = 1.0}, {.inlier_probabilities = -Eigen::VectorXd::Ones(20)}),
                  std::invalid_argument);
  CHECK_THROWS_AS(Search<LinearCircle>(PointMatrix::Ones(9, 3), {.max_residual = 1.0}), std::invalid_argument);
}

TEST_CASE("Weights of draws change what is expected") {
  const StoppingOptions options{.stopping = Stopping::kConfidence, .confidence = 0.99};
  std::vector<std::uint8_t> inliers(100, 0);
  std::fill_n(inliers.begin(), 10, 1);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(100);
  StoppingRule alike(options, 100, 3), same(options, 100, 3, weights);
  weights.head(10).setConstant(9.0);
  StoppingRule guided(options, 100, 3, weights);
  for (StoppingRule* rule : {&alike, &same, &guided}) rule->Update(inliers);
  CHECK(alike.inliers() == 10);
  CHECK_FALSE(alike.Finds(1000));
  CHECK_FALSE(same.Finds(1000));
  // As 50 of 100: 36 draws (the golden numbers of loop_test.cpp).
  CHECK(guided.Finds(36));
  CHECK_FALSE(guided.Finds(35));
}

}  // namespace
}  // namespace diffsac::ransac
