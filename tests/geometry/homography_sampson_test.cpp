#include "diffsac/geometry/homography_sampson.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "diffsac/geometry/homography.h"
#include "geometry/jacobian_check.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::CheckJacobian;
using testing::HomographyPoints;
using testing::RandomHomography;

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

}  // namespace

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

TEST_CASE("Sampson distances of homographies are those of the images exchanged") {
  Rng rng(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3Parameters h = RandomHomography(rng);
    const PointMatrix points = HomographyPoints(h, 1, rng, 0.01);
    const double* p = points.data();
    const double exchanged[] = {p[2], p[3], p[0], p[1]};
    const Matrix3Parameters back = AsParameters(AsMatrix(h).inverse());
    CHECK(HomographySampsonError(back, exchanged) == Approx(HomographySampsonError(h, p)).epsilon(1e-2));
  }
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

TEST_CASE("Distances over columns are the single ones; where H says nothing they are not finite") {
  Rng rng(4);
  const Matrix3Parameters h = RandomHomography(rng);
  const PointMatrix points = HomographyPoints(h, 37, rng, 2.0);
  const Eigen::MatrixXd columns = points;
  const double* pointers[4];
  for (int j = 0; j < 4; ++j) pointers[j] = columns.col(j).data();
  std::vector<double> distances(37);
  HomographySampsonDistances(h.data(), pointers, 0, 20, distances.data());
  HomographySampsonDistances(h.data(), pointers, 20, 37, distances.data() + 20);
  for (int i = 0; i < 37; ++i) CHECK(distances[i] == HomographySampsonError(h, points.data() + 4 * i));
  SymmetricTransferErrors(h, pointers, 0, 20, distances.data());
  SymmetricTransferErrors(h, pointers, 20, 37, distances.data() + 20);
  for (int i = 0; i < 37; ++i) CHECK(distances[i] == SymmetricTransferError(h, points.data() + 4 * i));
  const double match[] = {1.0, 2.0, 3.0, 4.0};
  CHECK_FALSE(HomographySampsonError(Matrix3Parameters::Zero(), match) <= 1e9);
  CHECK_FALSE(HomographySampsonError(Matrix3Parameters::Constant(std::nan("")), match) <= 1e9);
}

}  // namespace diffsac
