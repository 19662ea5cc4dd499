#include "diffsac/geometry/homography.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "geometry/two_view_problems.h"
#include "geometry/two_view_properties.h"

namespace diffsac {
namespace {

using testing::HomographyDistance;
using testing::HomographyPoints;
using testing::ModelDistance;
using testing::RandomHomography;

constexpr int kSet[] = {0, 1, 2, 3};

TEST_CASE("Homographies of four exact points are recovered") {
  Rng rng(1);
  int solved = 0, recovered = 0;
  for (int trial = 0; trial < 10000; ++trial) {
    const Matrix3Parameters truth = RandomHomography(rng);
    const PointMatrix points = HomographyPoints(truth, 4, rng);
    Matrix3Parameters model;
    if (Homography::SolveMinimal(points, kSet, &model) != 1) continue;
    ++solved;
    recovered += HomographyDistance(model, truth) < 1e-8 ? 1 : 0;
  }
  CHECK(solved == 10000);
  CHECK(recovered >= 9990);
}

TEST_CASE("A minimal homography maps its points onto each other, on its positive side") {
  Rng rng(2);
  for (int trial = 0; trial < 500; ++trial) {
    const PointMatrix points = HomographyPoints(RandomHomography(rng), 4, rng, 3.0);
    Matrix3Parameters model;
    if (Homography::SolveMinimal(points, kSet, &model) != 1) continue;
    CHECK(model.norm() == Approx(1.0).epsilon(1e-12));
    for (int i = 0; i < 4; ++i) {
      CHECK(Homography::Residual(model, points.data() + 4 * i) < 1e-6);
      CHECK(model[6] * points(i, 0) + model[7] * points(i, 1) + model[8] > 0.0);
    }
  }
}

TEST_CASE("Known homographies") {
  PointMatrix square(4, 4);
  square << 0, 0, 3, 4, 1, 0, 5, 4, 1, 1, 5, 6, 0, 1, 3, 6;  // twice as large and moved
  Eigen::Matrix3d expected;
  expected << 2, 0, 3, 0, 2, 4, 0, 0, 1;
  Matrix3Parameters model;
  REQUIRE(Homography::SolveMinimal(square, kSet, &model) == 1);
  CHECK(ModelDistance(model, AsParameters(expected)) < 1e-14);
  const double point[] = {1.0, 1.0, 8.0, 10.0};  // maps to (5, 6): off by (3, 4); back: (2.5, 3), off by (1.5, 2)
  CHECK(TransferError(model, point) == Approx(5.0));
  CHECK(SymmetricTransferError(model, point) == Approx(std::sqrt(0.5 * (25.0 + 6.25))));
  CHECK(Homography::Residual(-3.0 * model, point) == Approx(Homography::Residual(model, point)));
}

TEST_CASE("The orientation test refuses crossed, mirrored and folded quadrangles") {
  PointMatrix points(4, 4);
  points << 0, 0, 0, 0, 10, 0, 10, 0, 10, 10, 10, 10, 0, 10, 0, 10;
  Matrix3Parameters model;
  REQUIRE(Homography::SolveMinimal(points, kSet, &model) == 1);
  PointMatrix crossed = points;
  crossed.row(2).tail<2>().swap(crossed.row(3).tail<2>());
  CHECK(Homography::SolveMinimal(crossed, kSet, &model) == 0);
  PointMatrix mirrored = points;
  mirrored.col(2) *= -1.0;
  CHECK(Homography::SolveMinimal(mirrored, kSet, &model) == 0);
  CHECK(Homography::Fit(mirrored, Eigen::VectorXd::Ones(4), &model));
  PointMatrix folded = points;
  folded.row(2).tail<2>() << 1.0, 1.0;  // the corner pushed through the diagonal
  CHECK(Homography::SolveMinimal(folded, kSet, &model) == 0);
  folded.row(2).tail<2>() << 6.0, 6.0;  // not yet through
  CHECK(Homography::SolveMinimal(folded, kSet, &model) == 1);
}

TEST_CASE("A homography's mismatch with cameras is at most the motion of the second one, in distances of the plane") {
  Rng rng(8);
  Eigen::Matrix3d K1 = Eigen::Matrix3d::Identity(), K2 = K1;
  K1(0, 0) = K1(1, 1) = 800.0;
  K2(0, 0) = K2(1, 1) = 1100.0;
  K1(0, 2) = K2(0, 2) = 320.0;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d axis = Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(rng.Uniform(0.0, 3.0), axis).toRotationMatrix();
    const Eigen::Vector3d normal = Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    const Eigen::Vector3d motion =
        rng.Uniform(0.0, 0.9) * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    const auto mismatch = [&](const Eigen::Vector3d& t) {
      const Eigen::Matrix3d h = K2 * (rotation + t * normal.transpose()) * K1.inverse();
      return Homography::CameraMismatch(-2.0 * AsParameters(h), K1, K2);
    };
    CHECK(mismatch(Eigen::Vector3d::Zero()) == Approx(0.0).margin(1e-6));
    CHECK(mismatch(motion) <= motion.norm() + 1e-6);
    // Along the normal, the bound is met.
    CHECK(mismatch(motion.norm() * (rotation * normal)) == Approx(motion.norm()).epsilon(1e-5).margin(1e-6));
  }
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  const Matrix3Parameters rank_one = AsParameters(Eigen::Vector3d(1, 2, 3) * Eigen::RowVector3d(1, 1, 1));
  CHECK(Homography::CameraMismatch(rank_one, identity, identity) > 1e3);
  CHECK(Homography::CameraMismatch(rank_one, identity, identity) <= 1e6);
  CHECK(Homography::CameraMismatch(Matrix3Parameters::Constant(std::nan("")), identity, identity) == 1e6);
}

TEST_CASE("Sets with three collinear or equal points give no homography, at any scale") {
  for (const double scale : {1e-8, 1.0, 1e8}) {
    CAPTURE(scale);
    PointMatrix points(6, 4);
    points << 0, 0, 1, 2, 1, 1, 5, 1, 2, 2, 8, 9, 3, 0, 7, 1, 0, 0, 1, 2, 4, 5, 6, 9;
    points *= scale;
    Matrix3Parameters model;
    const int collinear[] = {0, 1, 2, 3}, twice[] = {0, 1, 3, 4}, same_index[] = {0, 1, 3, 3}, good[] = {0, 1, 3, 5};
    CHECK(Homography::SolveMinimal(points, collinear, &model) == 0);
    CHECK(Homography::SolveMinimal(points, twice, &model) == 0);
    CHECK(Homography::SolveMinimal(points, same_index, &model) == 0);
    PointMatrix identity = points;
    identity.rightCols<2>() = points.leftCols<2>();
    CHECK(Homography::SolveMinimal(identity, good, &model) == 1);
    PointMatrix swapped(points);
    swapped << points.rightCols<2>(), points.leftCols<2>();
    CHECK(Homography::SolveMinimal(swapped, collinear, &model) == 0);
  }
}

TEST_CASE("Weighted homography fits recover exact models and ignore points of no weight") {
  Rng rng(3);
  for (const int count : {4, 5, 20, 200}) {
    int recovered = 0;
    for (int trial = 0; trial < 200; ++trial) {
      const Matrix3Parameters truth = RandomHomography(rng);
      PointMatrix points = HomographyPoints(truth, count + 3, rng);
      Eigen::VectorXd weights(count + 3);
      for (double& weight : weights) weight = rng.Uniform(0.1, 2.0);
      weights.tail<3>().setZero();
      points.bottomRows<2>().setRandom();
      points(count + 2, 1) = std::nan("");
      Matrix3Parameters model;
      REQUIRE(Homography::Fit(points, weights, &model));
      recovered += HomographyDistance(model, truth) < 1e-8 ? 1 : 0;
    }
    CAPTURE(count);
    CHECK(recovered >= (count == 4 ? 190 : 198));
  }
}

TEST_CASE("A homography fit averages noise and heeds weights") {
  Rng rng(4);
  double few = 0.0, many = 0.0;
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix3Parameters truth = RandomHomography(rng);
    const PointMatrix clean = HomographyPoints(truth, 50, rng);
    const auto error = [&](int count) {
      PointMatrix points = HomographyPoints(truth, count, rng, 1.0);
      Matrix3Parameters model;
      REQUIRE(Homography::Fit(points, Eigen::VectorXd::Ones(count), &model));
      double sum = 0.0;
      for (int i = 0; i < 50; ++i) sum += TransferError(model, clean.data() + 4 * i);
      return sum / 50.0;
    };
    few += error(16) / 100.0;
    many += error(256) / 100.0;
  }
  CHECK(few < 3.0);
  CHECK(many < 0.4 * few);  // 1/4 by the law of large numbers
}

TEST_CASE("Homography: shared properties") {
  Rng rng(5);
  const Matrix3Parameters truth = RandomHomography(rng);
  const PointMatrix points = HomographyPoints(truth, 40, rng, 1.0);
  testing::CheckColumnResiduals<Homography>(truth, points);
  testing::CheckHostileInput<Homography>();
  testing::CheckScales<Homography>(HomographyPoints(truth, 30, rng));
  testing::CheckWeightsAreRepetitions<Homography>(points, rng);
}

TEST_CASE("Distances from a singular homography and of points on the horizon are how far points have to move") {
  const double point[] = {1.0, 2.0, 3.0, 4.0};
  Matrix3Parameters singular;  // onto the line y2 = 2 x2
  singular << 1, 2, 3, 2, 4, 6, 0, 0, 1;
  CHECK(Homography::Residual(singular, point) == Approx(std::sqrt(2.0 * 189.0 / 26.0)));
  CHECK_FALSE(SymmetricTransferError(singular, point) <= 1e300);
  Matrix3Parameters horizon;
  horizon << 1, 0, 0, 0, 1, 0, 1, 0, -1;
  CHECK(Homography::Residual(horizon, point) == Approx(std::sqrt(0.5)));
  CHECK_FALSE(SymmetricTransferError(horizon, point) <= 1e300);
  // Neither point can move to where the errors vanish.
  const double stuck[] = {1.0, 2.0, 1.0, 4.0};
  CHECK_FALSE(Homography::Residual(horizon, stuck) <= 1e300);
}

}  // namespace
}  // namespace diffsac
