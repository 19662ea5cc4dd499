#include "diffsac/geometry/essential.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "diffsac/geometry/svd3.h"
#include "geometry/planar_scene.h"
#include "geometry/two_view_problems.h"
#include "geometry/two_view_properties.h"

namespace diffsac {
namespace {

using testing::ModelDistance;
using testing::RandomProblem;

constexpr int kSet[] = {0, 1, 2, 3, 4};

double Closest(const Matrix3Parameters* models, int count, const Matrix3Parameters& truth) {
  double best = 2.0;
  for (int i = 0; i < count; ++i) best = std::min(best, ModelDistance(models[i], truth));
  return best;
}

/// |2 E Eᵀ E - tr(E Eᵀ) E|, zero for essential matrices.
double EssentialDefect(const Matrix3Parameters& model) {
  const Eigen::Matrix3d e = AsMatrix(model);
  return (2.0 * e * e.transpose() * e - (e * e.transpose()).trace() * e).norm();
}

TEST_CASE("The 5-point solver recovers E, with the expected number of real solutions") {
  Rng rng(1);
  int recovered = 0, precise = 0, all = 0, oriented = 0, with_solutions[11] = {};
  for (int trial = 0; trial < 10000; ++trial) {
    const auto problem = RandomProblem(5, rng);
    Matrix3Parameters models[10];
    const int solutions = SolveFivePoints(problem.normalized, kSet, models);
    REQUIRE(solutions <= 10);
    ++with_solutions[solutions];
    all += solutions;
    const int count = Essential::SolveMinimal(problem.normalized, kSet, models);
    oriented += count;
    const double error = Closest(models, count, problem.essential);
    recovered += error < 1e-6 ? 1 : 0;
    precise += error < 1e-10 ? 1 : 0;
  }
  CAPTURE(all, oriented, recovered, precise);
  CHECK(recovered >= 9995);
  CHECK(precise >= 9950);
  CHECK(all > 40000);  // 4 to 5 real solutions on average (Nistér 2004 reports 4.55)
  CHECK(all < 52000);
  CHECK(oriented < all);
  CHECK(oriented >= 10000);
  // Complex roots come in pairs, so the number is even but for roots that merge; ten are rare.
  int odd = 0;
  for (int i = 1; i <= 9; i += 2) odd += with_solutions[i];
  CAPTURE(odd, with_solutions[0], with_solutions[2], with_solutions[4], with_solutions[6], with_solutions[8],
          with_solutions[10]);
  CHECK(odd < 20);
  CHECK(with_solutions[0] < 5);
  CHECK(with_solutions[2] > 400);
  CHECK(with_solutions[4] > 3000);
  CHECK(with_solutions[6] > 1000);
  CHECK(with_solutions[8] > 50);
  CHECK(with_solutions[10] < 100);
}

TEST_CASE("Solutions are essential matrices through the points, noisy ones too") {
  Rng rng(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto problem = RandomProblem(5, rng, 2.0);
    Matrix3Parameters models[10];
    const int count = Essential::SolveMinimal(problem.normalized, kSet, models);
    for (int k = 0; k < count; ++k) {
      CHECK(models[k].norm() == Approx(1.0).epsilon(1e-12));
      CHECK(EssentialDefect(models[k]) < 1e-10);
      CHECK(std::abs(AsMatrix(models[k]).determinant()) < 1e-10);
      for (int i = 0; i < 5; ++i) CHECK(Essential::Residual(models[k], problem.normalized.data() + 4 * i) < 1e-11);
      CHECK(SatisfiesOrientation(AsMatrix(models[k]), testing::AsRows(problem.normalized), 5));
      for (int other = 0; other < k; ++other) CHECK(ModelDistance(models[k], models[other]) > 1e-9);
    }
  }
}

TEST_CASE("Cheirality of a set: true for the true motion, and as the four poses say for any") {
  Rng rng(8);
  for (int trial = 0; trial < 500; ++trial) {
    const auto problem = RandomProblem(5, rng);
    double points[5][4];
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 4; ++j) points[i][j] = problem.normalized(i, j);
    CHECK(SatisfiesCheirality(AsMatrix(problem.essential), points, 5));
    CHECK(SatisfiesCheirality(-3.0 * AsMatrix(problem.essential), points, 5));
    Matrix3Parameters models[10];
    const int count = SolveFivePoints(problem.normalized, kSet, models);
    for (int k = 0; k < count; ++k) {
      const Eigen::Matrix3d e = AsMatrix(models[k]);
      bool any = false, small_parallax = false;
      for (const RelativePose& pose : DecomposeEssential(e)) {
        int in_front = 0;
        for (int i = 0; i < 5; ++i) {
          in_front += InFront(pose, points[i]) ? 1 : 0;
          const Eigen::Vector3d a = pose.rotation * Eigen::Vector3d(points[i][0], points[i][1], 1.0);
          const Eigen::Vector3d b(points[i][2], points[i][3], 1.0);
          small_parallax = small_parallax || a.cross(b).norm() < 2e-3 * a.norm() * b.norm();
        }
        any = any || in_front == 5;
      }
      if (!small_parallax) CHECK(SatisfiesCheirality(e, points, 5) == any);
    }
    // A point at infinity has no say, whichever way noise pushes it.
    const Eigen::Vector3d far = problem.pose.rotation * Eigen::Vector3d(points[0][0], points[0][1], 1.0);
    for (const double push : {-1e-5, 1e-5}) {
      points[0][2] = far[0] / far[2] + push * problem.pose.translation[0];
      points[0][3] = far[1] / far[2] + push * problem.pose.translation[1];
      CHECK(SatisfiesCheirality(AsMatrix(problem.essential), points, 5));
    }
  }
}

TEST_CASE("Special motions and planes are no trouble for the 5-point solver") {
  Rng rng(3);
  const auto share_recovered = [&](const RelativePose& pose, bool plane) {
    int recovered = 0;
    for (int trial = 0; trial < 200; ++trial) {
      PointMatrix points(5, 4);
      for (int i = 0; i < 5; ++i) {
        const double x = rng.Uniform(-0.6, 0.6), y = rng.Uniform(-0.6, 0.6);
        const double depth = plane ? 4.0 / (1.0 + 0.2 * x - 0.3 * y) : rng.Uniform(2.0, 8.0);
        const Eigen::Vector3d second = pose.rotation * Eigen::Vector3d(x * depth, y * depth, depth) + pose.translation;
        points.row(i) << x, y, second[0] / second[2], second[1] / second[2];
      }
      Matrix3Parameters models[10];
      const int count = SolveFivePoints(points, kSet, models);
      recovered += Closest(models, count, AsParameters(EssentialFromPose(pose))) < 1e-6 ? 1 : 0;
    }
    return recovered / 200.0;
  };
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Matrix3d upside_down = Eigen::AngleAxisd(3.14159265, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d axes[] = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ(),
                                  -Eigen::Vector3d::UnitZ(), Eigen::Vector3d(1, 1, 0).normalized()};
  const Eigen::Matrix3d rotations[] = {Eigen::Matrix3d::Identity(), turned, upside_down};
  for (const Eigen::Vector3d& t : axes) {
    for (const Eigen::Matrix3d& r : rotations) {
      CAPTURE(t.transpose(), r);
      CHECK(share_recovered({r, t}, false) >= 0.98);
    }
    CHECK(share_recovered({turned, t}, true) >= 0.97);
  }
}

TEST_CASE("Weighted fits recover exact E and give essential matrices from noise") {
  Rng rng(4);
  for (const int count : {8, 12, 50}) {
    int recovered = 0;
    for (int trial = 0; trial < 300; ++trial) {
      auto problem = RandomProblem(count + 1, rng);
      Eigen::VectorXd weights(count + 1);
      for (double& weight : weights) weight = rng.Uniform(0.1, 2.0);
      weights[count] = 0.0;
      problem.normalized(count, 2) = std::nan("");
      Matrix3Parameters model;
      REQUIRE(Essential::Fit(problem.normalized, weights, &model));
      CHECK(EssentialDefect(model) < 1e-14);
      recovered += ModelDistance(model, problem.essential) < 1e-6 ? 1 : 0;
    }
    CAPTURE(count, recovered);
    CHECK(recovered >= (count == 8 ? 280 : 298));
  }
  const auto noisy = RandomProblem(100, rng, 1.0);
  Matrix3Parameters model;
  REQUIRE(Essential::Fit(noisy.normalized, Eigen::VectorXd::Ones(100), &model));
  CHECK(EssentialDefect(model) < 1e-14);
  CHECK(ModelDistance(model, noisy.essential) < 0.2);
}

TEST_CASE(
    "Least squares from a start are essential, lower the squares, and are right on a plane, unlike eight equations") {
  int better = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Rng rng(seed);
    const auto scene = testing::MakePlanarScene(200, 1.0, 0.0, 0.5, rng);
    const PointMatrix& points = scene.views.normalized;
    const Eigen::VectorXd weights = Eigen::VectorXd::Ones(points.rows());
    const auto squares = [&](const Matrix3Parameters& model) {
      double sum = 0.0;
      for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const double r = Essential::Residual(model, points.data() + 4 * i);
        sum += r * r;
      }
      return sum;
    };
    Matrix3Parameters fitted = scene.views.essential, linear;
    REQUIRE(Essential::FitFrom(points, weights, &fitted));
    CHECK(EssentialDefect(fitted) < 1e-14);
    CHECK(squares(fitted) <= squares(scene.views.essential));
    if (!Essential::Fit(points, weights, &linear) || squares(fitted) < 0.5 * squares(linear)) ++better;
  }
  CHECK(better >= 25);
}

TEST_CASE("Least squares from a start leave the model where there are too few points") {
  Rng rng(4);
  const auto problem = RandomProblem(10, rng);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(10);
  weights.head<4>().setOnes();
  Matrix3Parameters model = problem.essential;
  CHECK_FALSE(Essential::FitFrom(problem.normalized, weights, &model));
  CHECK(model == problem.essential);
  weights[4] = std::nan("");
  CHECK_FALSE(Essential::FitFrom(problem.normalized, weights, &model));
}

TEST_CASE("The closest essential matrix has singular values (s, s, 0) and leaves essential matrices as they are") {
  Rng rng(5);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Matrix3d random = Eigen::Matrix3d::NullaryExpr([&](int, int) { return rng.Normal(); });
    const Svd3 before = ComputeSvd3(random), after = ComputeSvd3(ClosestEssential(random));
    CHECK(after.values[0] == Approx(0.5 * (before.values[0] + before.values[1])));
    CHECK(after.values[1] == Approx(after.values[0]));
    CHECK(after.values[2] < 1e-14);
    const Eigen::Matrix3d e = EssentialFromPose(testing::RandomPose(rng));
    CHECK((ClosestEssential(e) - e).norm() < 1e-14);
  }
}

TEST_CASE("Essential: shared properties") {
  Rng rng(6);
  const auto problem = RandomProblem(40, rng, 1.0);
  testing::CheckColumnResiduals<Essential>(problem.essential, problem.normalized);
  testing::CheckHostileInput<Essential>();
  testing::CheckWeightsAreRepetitions<Essential>(problem.normalized, rng);
}

}  // namespace
}  // namespace diffsac
