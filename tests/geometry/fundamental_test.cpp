#include "diffsac/geometry/fundamental.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/geometry/null_space.h"
#include "geometry/two_view_problems.h"
#include "geometry/two_view_properties.h"

namespace diffsac {
namespace {

using testing::FundamentalDistance;
using testing::ModelDistance;
using testing::RandomProblem;

constexpr int kSet[] = {0, 1, 2, 3, 4, 5, 6, 7};

double Closest(const Matrix3Parameters* models, int count, const Matrix3Parameters& truth) {
  double best = 2.0;
  for (int i = 0; i < count; ++i) best = std::min(best, FundamentalDistance(models[i], truth));
  return best;
}

TEST_CASE("The 7-point solver recovers F, with the expected number of real solutions") {
  Rng rng(1);
  int recovered = 0, all = 0, oriented = 0, with_solutions[4] = {};
  for (int trial = 0; trial < 10000; ++trial) {
    const auto problem = RandomProblem(7, rng);
    Matrix3Parameters models[3];
    const int solutions = SolveSevenPoints(problem.pixels, kSet, models);
    REQUIRE(solutions <= 3);
    ++with_solutions[solutions];
    all += solutions;
    const int count = Fundamental::SolveMinimal(problem.pixels, kSet, models);
    oriented += count;
    recovered += Closest(models, count, problem.fundamental) < 1e-6 ? 1 : 0;
  }
  CAPTURE(recovered, all, oriented, with_solutions[0], with_solutions[1], with_solutions[2], with_solutions[3]);
  CHECK(recovered >= 9980);
  // A cubic has one or three real roots; two only where a pair of them merges, none never.
  CHECK(with_solutions[0] == 0);
  CHECK(with_solutions[1] > 1000);
  CHECK(with_solutions[2] < 20);
  CHECK(with_solutions[3] > 5000);
  CHECK(all > 20000);  // one or three: between 1 and 3 on average, mostly three for real scenes
  CHECK(all < 30000);
  CHECK(oriented < all);  // the orientation test removes wrong ones only
  CHECK(oriented >= 10000);
}

TEST_CASE("The 8-point solver recovers F") {
  Rng rng(2);
  int recovered = 0, solved = 0;
  for (int trial = 0; trial < 10000; ++trial) {
    const auto problem = RandomProblem(8, rng);
    Matrix3Parameters model;
    const int count = Fundamental8::SolveMinimal(problem.pixels, kSet, &model);
    solved += count;
    recovered += Closest(&model, count, problem.fundamental) < 1e-6 ? 1 : 0;
  }
  CHECK(solved >= 9999);
  CHECK(recovered >= 9980);
}

TEST_CASE("Minimal solutions have rank 2, unit norm and pass through their points, noisy ones too") {
  Rng rng(3);
  for (int trial = 0; trial < 500; ++trial) {
    const auto problem = RandomProblem(8, rng, 2.0);
    Matrix3Parameters models[3];
    const int count = Fundamental::SolveMinimal(problem.pixels, kSet, models);
    for (int k = 0; k < count; ++k) {
      CHECK(models[k].norm() == Approx(1.0).epsilon(1e-12));
      for (int i = 0; i < 7; ++i) CHECK(Fundamental::Residual(models[k], problem.pixels.data() + 4 * i) < 1e-5);
      CHECK(SatisfiesOrientation(AsMatrix(models[k]), testing::AsRows(problem.pixels), 7));
    }
    Matrix3Parameters eight;
    REQUIRE(Fundamental8::SolveMinimal(problem.pixels, kSet, &eight) == 1);
    CHECK(std::abs(AsMatrix(eight).determinant()) < 1e-16);
  }
}

TEST_CASE("The 7-point solver gives the value of the Matlab reference") {
  // The points and the result of COLMAP's test (fundamental_matrix_test.cc), computed there with Matlab.
  PointMatrix points(7, 4);
  points << 0.4964, 1.0577, 0.7570, 2.7340, 0.3650, -0.0919, 0.3961, 0.6981, -0.5412, 0.0159, -0.6014, 0.7110, -0.5239,
      0.9467, -0.7385, 2.2712, 0.3467, 0.5301, 0.4177, 1.2132, 0.2797, 0.0012, 0.3052, 0.4835, -0.1986, 0.0460, -0.2171,
      0.5057;
  Eigen::Matrix3d expected;
  expected << 4.81441976, -8.16978909, 6.73133404, 5.16247992, 0.19325606, -2.87239381, -9.92570126, 3.64159554, 1.0;
  Matrix3Parameters models[3];
  const int count = SolveSevenPoints(points, kSet, models);
  REQUIRE(count == 1);
  double best = 1e9;
  for (int k = 0; k < count; ++k)
    best = std::min(best, (AsMatrix(models[k]) / models[k][8] - expected).cwiseAbs().maxCoeff());
  CHECK(best < 1e-6);
}

TEST_CASE("The 8-point solver gives the value of the Matlab reference") {
  PointMatrix points(8, 4);
  points << 1.839035, 1.924743, 1.002114, 1.129644, 0.543582, 0.375221, 1.521742, 1.846002, 0.473240, 0.142522,
      1.084332, 0.275134, 0.964910, 0.598376, 0.293328, 0.588992, 0.102388, 0.140092, 0.839509, 0.087290, 15.994343,
      9.622164, 1.779735, 1.116857, 0.285901, 0.430055, 0.878616, 0.602447, 0.091150, 0.254594, 0.642616, 1.028681;
  Eigen::Matrix3d expected;
  expected << -0.217859, 0.419282, -0.0343075, -0.0717941, 0.0451643, 0.0216073, 0.248062, -0.429478, 0.0221019;
  // The reference normalises the root mean square distance to √2, we the mean: with noise the closest matrix of rank 2
  // depends on it, a little. So its value belongs to its own normalisation of the same null vector.
  Eigen::Matrix3d normalization[2];
  double rows[8][9], basis[1][9];
  for (int image = 0; image < 2; ++image) {
    const Eigen::RowVector2d centre = points.middleCols<2>(2 * image).colwise().mean();
    const double mean_square = (points.middleCols<2>(2 * image).rowwise() - centre).rowwise().squaredNorm().mean();
    normalization[image] = ImageNormalization{centre[0], centre[1], std::sqrt(2.0 / mean_square)}.Matrix();
  }
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d x1 = normalization[0] * Eigen::Vector3d(points(i, 0), points(i, 1), 1.0);
    const Eigen::Vector3d x2 = normalization[1] * Eigen::Vector3d(points(i, 2), points(i, 3), 1.0);
    for (int j = 0; j < 9; ++j) rows[i][j] = x2[j / 3] * x1[j % 3];
  }
  REQUIRE(OrthogonalComplement(rows, basis));
  const Eigen::Matrix3d null = AsMatrix(Eigen::Map<const Matrix3Parameters>(basis[0]));
  const Eigen::Matrix3d f = normalization[1].transpose() * ClosestRankTwo(null) * normalization[0];
  CHECK(ModelDistance(AsParameters(f), AsParameters(expected)) < 1e-5);
  Matrix3Parameters minimal, fitted;
  REQUIRE(Fundamental8::SolveMinimal(points, kSet, &minimal) == 1);
  REQUIRE(Fundamental::Fit(points, Eigen::VectorXd::Ones(8), &fitted));
  CHECK(ModelDistance(minimal, AsParameters(expected)) < 5e-3);
  CHECK(ModelDistance(minimal, fitted) < 1e-8);
}

TEST_CASE("Sampson errors with known values") {
  // A camera moving sideways: epipolar lines are rows, x2ᵀ F x1 = y1 - y2.
  Matrix3Parameters f;
  f << 0, 0, 0, 0, 0, -1, 0, 1, 0;
  const double point[] = {3.0, 5.0, 8.0, 7.0};
  CHECK(SampsonError(f, point) == Approx(2.0 / std::sqrt(2.0)));
  CHECK(Fundamental::Residual(-7.0 * f, point) == Approx(SampsonError(f, point)));
  Rng rng(4);
  const auto problem = RandomProblem(50, rng);
  for (int i = 0; i < 50; ++i) CHECK(SampsonError(problem.fundamental, problem.pixels.data() + 4 * i) < 1e-9);
}

TEST_CASE("Sampson's distance is the distance to the nearest exact correspondence, to first order") {
  Rng rng(5);
  const auto problem = RandomProblem(100, rng);
  const Eigen::Matrix3d f = AsMatrix(problem.fundamental);
  for (int i = 0; i < 100; ++i) {
    // Move along the constraint's gradient by 0.01 px: the distance back is just that.
    const Eigen::Vector3d x1(problem.pixels(i, 0), problem.pixels(i, 1), 1.0);
    const Eigen::Vector3d x2(problem.pixels(i, 2), problem.pixels(i, 3), 1.0);
    Eigen::Vector4d gradient;
    gradient << (f.transpose() * x2).head<2>(), (f * x1).head<2>();
    const Eigen::Vector4d moved = problem.pixels.row(i).transpose() + 0.01 * gradient.normalized();
    CHECK(SampsonError(problem.fundamental, moved.data()) == Approx(0.01).epsilon(1e-3));
  }
}

TEST_CASE("A small step within the epipolar plane turns as the epipolar lines do, and no other turn does") {
  Rng rng(17);
  for (int trial = 0; trial < 50; ++trial) {
    const testing::TwoViewProblem views = testing::RandomProblem(1, rng);
    const double* x = views.pixels.data();
    const auto agrees = [&](double turn) {
      const double direction[] = {std::cos(turn), std::sin(turn)};
      return TurnsAsLines(views.fundamental.data(), x[0], x[1], x[2], x[3], direction);
    };
    // The point, and one beside it in the direction from camera to camera, on both images.
    const Eigen::Vector3d ray = views.k1.inverse() * Eigen::Vector3d(x[0], x[1], 1.0);
    const Eigen::Vector3d other = views.pose.rotation * ray,
                          end = views.k2.inverse() * Eigen::Vector3d(x[2], x[3], 1.0);
    const double depth = -end.cross(views.pose.translation).norm() / end.cross(other).norm();
    const Eigen::Vector3d point = std::abs(depth) * ray;
    const Eigen::Vector3d beside = point + 1e-4 * views.pose.rotation.transpose() * views.pose.translation;
    const Eigen::Vector2d step1 = (views.k1 * beside).hnormalized() - (views.k1 * point).hnormalized();
    const auto second = [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
      return (views.k2 * (views.pose.rotation * p + views.pose.translation)).hnormalized();
    };
    const Eigen::Vector2d step2 = second(beside) - second(point);
    const double turn = std::atan2(step2[1], step2[0]) - std::atan2(step1[1], step1[0]);
    CHECK(agrees(turn));
    CHECK(agrees(turn + 0.6));
    CHECK(agrees(turn - 0.6));
    for (const double off : {0.7, 1.5, 3.1, -0.7, -1.5}) CHECK_FALSE(agrees(turn + off));
  }
}

TEST_CASE("The oriented epipolar constraint holds for real scenes and breaks for points behind a camera") {
  Rng rng(6);
  for (int trial = 0; trial < 500; ++trial) {
    auto problem = RandomProblem(8, rng);
    CHECK(SatisfiesOrientation(AsMatrix(problem.fundamental), testing::AsRows(problem.pixels), 8));
    CHECK(SatisfiesOrientation(AsMatrix(-problem.fundamental), testing::AsRows(problem.pixels), 8));
    // A point behind the second camera alone, on its epipolar line.
    const Eigen::Vector3d first(0.2, 0.1, 1.0);
    const Eigen::Vector3d turned = problem.pose.rotation * first;
    if (problem.pose.translation[2] > -0.2) continue;
    const double depth = -0.5 * problem.pose.translation[2] / turned[2];
    const Eigen::Vector3d second = depth * turned + problem.pose.translation;
    REQUIRE(second[2] < 0.0);
    problem.pixels.row(3) << (problem.k1 * first).hnormalized().transpose(),
        (problem.k2 * second).hnormalized().transpose();
    CHECK_FALSE(SatisfiesOrientation(AsMatrix(problem.fundamental), testing::AsRows(problem.pixels), 8));
  }
}

TEST_CASE("Weighted fits recover exact F, have rank 2 and ignore points of no weight") {
  Rng rng(7);
  for (const int count : {8, 12, 50}) {
    int recovered = 0;
    for (int trial = 0; trial < 300; ++trial) {
      auto problem = RandomProblem(count + 2, rng);
      Eigen::VectorXd weights(count + 2);
      for (double& weight : weights) weight = rng.Uniform(0.1, 2.0);
      weights.tail<2>().setZero();
      problem.pixels.row(count) << 1.0, 2.0, 3.0, 4.0;
      problem.pixels(count + 1, 0) = std::nan("");
      Matrix3Parameters model;
      REQUIRE(Fundamental::Fit(problem.pixels, weights, &model));
      CHECK(std::abs(AsMatrix(model).determinant()) < 1e-15);
      recovered += FundamentalDistance(model, problem.fundamental) < 1e-6 ? 1 : 0;
    }
    CAPTURE(count, recovered);
    CHECK(recovered >= (count == 8 ? 280 : 298));
  }
}

TEST_CASE("The closest matrix of rank 2") {
  Rng rng(8);
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3Parameters random = AsParameters(Eigen::Matrix3d::NullaryExpr([&](int, int) { return rng.Normal(); }));
    const Eigen::Matrix3d closest = ClosestRankTwo(AsMatrix(random));
    CHECK(std::abs(closest.determinant()) < 1e-15);
    // What is missing is the least singular value; its square is the least eigenvalue: det = product of all.
    const double gap = (AsMatrix(random) - closest).norm();
    const Eigen::Matrix3d gram = AsMatrix(random).transpose() * AsMatrix(random);
    CHECK((gram - gap * gap * Eigen::Matrix3d::Identity()).determinant() == Approx(0.0).margin(1e-10));
  }
}

TEST_CASE("Fundamental: shared properties") {
  Rng rng(9);
  const auto problem = RandomProblem(40, rng, 1.0);
  testing::CheckColumnResiduals<Fundamental>(problem.fundamental, problem.pixels);
  testing::CheckHostileInput<Fundamental>();
  testing::CheckHostileInput<Fundamental8>();
  const auto exact = RandomProblem(30, rng);
  testing::CheckScales<Fundamental>(exact.pixels);
  testing::CheckScales<Fundamental8>(exact.pixels);
  testing::CheckWeightsAreRepetitions<Fundamental>(problem.pixels, rng);
}

TEST_CASE("The epipoles as a correspondence have residual 0, not NaN") {
  Matrix3Parameters f;
  f << 0, -1, 0, 1, 0, 0, 0, 0, 0;  // forward motion: both epipoles at the origin
  const double origin[] = {0.0, 0.0, 0.0, 0.0};
  CHECK(Fundamental::Residual(f, origin) == 0.0);
}

TEST_CASE("Exact planes leave more than one F: the fit says so") {
  Rng rng(10);
  const PointMatrix points = testing::HomographyPoints(testing::RandomHomography(rng), 30, rng);
  Matrix3Parameters model;
  CHECK_FALSE(Fundamental::Fit(points, Eigen::VectorXd::Ones(30), &model));
  CHECK(Fundamental8::SolveMinimal(points, kSet, &model) == 0);
}

TEST_CASE("How badly F fits cameras is the difference of the singular values of its E") {
  for (int trial = 0; trial < 20; ++trial) {
    Rng rng(trial);
    const testing::TwoViewProblem views = RandomProblem(8, rng);
    CHECK(Fundamental::CameraMismatch(views.fundamental, views.k1, views.k2) == Approx(0.0).margin(1e-6));
    const Eigen::Matrix3d k1 = testing::RandomCamera(rng), k2 = testing::RandomCamera(rng);
    const Eigen::Vector3d values = (k2.transpose() * AsMatrix(views.fundamental) * k1).jacobiSvd().singularValues();
    const double expected = (values[0] - values[1]) / values[1];
    CHECK(Fundamental::CameraMismatch(views.fundamental, k1, k2) == Approx(expected).epsilon(1e-6).margin(1e-6));
    CHECK(Fundamental::CameraMismatch(-3.0 * views.fundamental, k1, k2) == Approx(expected).epsilon(1e-6).margin(1e-6));
  }
  Matrix3Parameters rank_one = Matrix3Parameters::Zero();
  rank_one[8] = 1.0;
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  CHECK(std::isfinite(Fundamental::CameraMismatch(rank_one, identity, identity)));
  CHECK(Fundamental::CameraMismatch(rank_one, identity, identity) > 1e3);
}

}  // namespace
}  // namespace diffsac
