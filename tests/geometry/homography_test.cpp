#include "diffsac/geometry/homography.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "diffsac/geometry/homography_sampson.h"
#include "geometry/jacobian_check.h"
#include "geometry/two_view_problems.h"
#include "geometry/two_view_properties.h"

namespace diffsac {
namespace {

using testing::CheckJacobian;
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

double SquareOf(const Eigen::VectorXd& h, const double* point) {
  return HomographySampson(h.data(), point[0], point[1], point[2], point[3]).Square();
}

/// Half the weighted squares of these points.
double HalfCost(const Eigen::VectorXd& h, const PointMatrix& points, const Eigen::VectorXd& weights) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (weights[i] > 0.0) sum += 0.5 * weights[i] * SquareOf(h, points.data() + 4 * i);
  return sum;
}

NormalEquations Sums(const Matrix3Parameters& h, const PointMatrix& points, const Eigen::VectorXd& weights) {
  const Eigen::MatrixXd columns = points;
  const double* pointers[4];
  for (int j = 0; j < 4; ++j) pointers[j] = columns.col(j).data();
  return SumHomographySampsonEquations(h.data(), pointers, weights.data(), static_cast<int>(points.rows()));
}

/// A homography near the identity and matches near it, as in normalised coordinates.
Matrix3Parameters NearIdentity(Rng& rng) {
  Matrix3Parameters h = AsParameters(Eigen::Matrix3d::Identity());
  for (double& value : h) value += 0.1 * rng.Normal();
  return h;
}

PointMatrix RandomMatches(int count, Rng& rng) {
  PointMatrix points(count, 4);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = rng.Uniform(-1.0, 1.0);
  return points;
}

TEST_CASE("Sampson distances of homographies: known values") {
  // Moved by (3, 4): the transfer error itself.
  Eigen::Matrix3d move = Eigen::Matrix3d::Identity();
  move(0, 2) = 3.0;
  move(1, 2) = 4.0;
  const double off[] = {0.0, 0.0, 6.0, 8.0};
  CHECK(HomographySampsonError(AsParameters(move), off) == Approx(5.0));
  CHECK(HomographySampsonError(-2.0 * AsParameters(move), off) == Approx(5.0));
  // Twice as large: an error d in image 2 is undone by d/5 there and 2d/5 in image 1, √(d²/5) in all.
  const Matrix3Parameters twice = AsParameters(Eigen::Vector3d(2.0, 2.0, 1.0).asDiagonal());
  const double doubled[] = {1.0, 1.0, 2.0 + 3.0, 2.0 + 4.0};
  CHECK(HomographySampsonError(twice, doubled) == Approx(std::sqrt(2.0 * 25.0 / 5.0)));
  // Squeezed to a tenth across: down the image as ever, across nearly all the error is image 2's.
  const Matrix3Parameters squeezed = AsParameters(Eigen::Vector3d(0.1, 1.0, 1.0).asDiagonal());
  const double across[] = {10.0, 10.0, 2.0, 10.0}, down[] = {10.0, 10.0, 1.0, 11.0};
  CHECK(HomographySampsonError(squeezed, across) == Approx(std::sqrt(2.0 / 1.01)));
  CHECK(HomographySampsonError(squeezed, down) == Approx(1.0));
  CHECK(SymmetricTransferError(squeezed, across) == Approx(std::sqrt(0.5 * (1.0 + 100.0))));
}

TEST_CASE("The Sampson distance is the least motion of both points, where that is small") {
  Rng rng(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3Parameters h = RandomHomography(rng);
    const PointMatrix points = HomographyPoints(h, 1, rng, 0.05);
    // Newton's steps onto the homography, each the least one of four coordinates.
    Eigen::Vector4d at = points.row(0).transpose();
    for (int step = 0; step < 5; ++step) {
      const HomographySampson s(h.data(), at[0], at[1], at[2], at[3]);
      Eigen::Matrix<double, 2, 4> jacobian;
      jacobian << s.p0, s.p1, s.w, 0.0, s.q0, s.q1, 0.0, s.w;
      const Eigen::Vector2d error = Eigen::Vector2d(s.e0, s.e1) + jacobian * (points.row(0).transpose() - at);
      at = points.row(0).transpose() - jacobian.transpose() * (jacobian * jacobian.transpose()).inverse() * error;
    }
    const double motion = (at - points.row(0).transpose()).norm();
    CHECK(HomographySampsonError(h, points.data()) == Approx(std::sqrt(2.0) * motion).epsilon(1e-2));
  }
}

TEST_CASE("The normal equations' gradient is exact, and their matrix that of the whitened errors") {
  Rng rng(3);
  for (const int count : {1, 3, 4, 7, 64}) {
    Matrix3Parameters h = NearIdentity(rng);
    PointMatrix points = RandomMatches(count, rng);
    Eigen::VectorXd weights(count);
    for (double& weight : weights) weight = rng.Below(3) == 0 ? 0.0 : rng.Uniform(0.1, 2.0);
    if (count > 4) {
      // One on the horizon that cannot move to where the errors vanish counts nothing without weight.
      h.tail<3>() << 1.0, 0.0, 0.0;
      points.col(0).array() += 2.0;
      points.row(2) << 0.0, 0.5, h[0], h[3];
      weights[2] = 0.0;
    }
    const NormalEquations sums = Sums(h, points, weights);
    CheckJacobian([&](const Eigen::VectorXd& x) { return Eigen::VectorXd::Constant(1, HalfCost(x, points, weights)); },
                  h, sums.gradient.transpose(), 1e-6);
    Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
    for (int i = 0; i < count; ++i) {
      if (weights[i] == 0.0) continue;
      const double* p = points.data() + 4 * i;
      const HomographySampson s(h.data(), p[0], p[1], p[2], p[3]);
      const Eigen::RowVector3d x(p[0], p[1], 1.0);
      Eigen::Matrix<double, 2, 9> derivative = Eigen::Matrix<double, 2, 9>::Zero();
      derivative.block<1, 3>(0, 0) = derivative.block<1, 3>(1, 3) = -x;
      derivative.block<1, 3>(0, 6) = p[2] * x;
      derivative.block<1, 3>(1, 6) = p[3] * x;
      Eigen::Matrix<double, 2, 4> jacobian;
      jacobian << s.p0, s.p1, s.w, 0.0, s.q0, s.q1, 0.0, s.w;
      normal += 2.0 * weights[i] * derivative.transpose() * (jacobian * jacobian.transpose()).inverse() * derivative;
    }
    CHECK((sums.normal - normal).norm() <= 1e-10 * (1.0 + normal.norm()));
  }
}

TEST_CASE("Transfer errors over columns are the single ones, where H says nothing they are not finite") {
  Rng rng(4);
  const Matrix3Parameters h = RandomHomography(rng);
  const PointMatrix points = HomographyPoints(h, 37, rng, 2.0);
  const Eigen::MatrixXd columns = points;
  const double* pointers[4];
  for (int j = 0; j < 4; ++j) pointers[j] = columns.col(j).data();
  std::vector<double> distances(37);
  SymmetricTransferErrors(h, pointers, 0, 20, distances.data());
  SymmetricTransferErrors(h, pointers, 20, 37, distances.data() + 20);
  for (int i = 0; i < 37; ++i) CHECK(distances[i] == SymmetricTransferError(h, points.data() + 4 * i));
  const double match[] = {1.0, 2.0, 3.0, 4.0};
  CHECK_FALSE(HomographySampsonError(Matrix3Parameters::Zero(), match) <= 1e9);
  CHECK_FALSE(HomographySampsonError(Matrix3Parameters::Constant(std::nan("")), match) <= 1e9);
}

}  // namespace
}  // namespace diffsac
