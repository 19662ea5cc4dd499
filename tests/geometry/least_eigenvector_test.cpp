#include "diffsac/geometry/least_eigenvector.h"

#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

/// Q diag(values) Qᵀ; the answer is Q's first column.
Matrix9 WithEigenvalues(const Vector9& values, Rng& rng, Vector9* least) {
  const Matrix9 random = Matrix9::NullaryExpr([&](int, int) { return rng.Normal(); });
  const Matrix9 q = random.householderQr().householderQ();
  *least = q.col(0);
  return q * values.asDiagonal() * q.transpose();
}

double Error(const Vector9& a, const Vector9& b) { return std::min((a - b).norm(), (a + b).norm()); }

TEST_CASE("The least eigenvector is found for clean, noisy and nearly isotropic matrices of any scale") {
  Rng rng(1);
  for (int trial = 0; trial < 2000; ++trial) {
    Vector9 values;
    values[0] = trial % 3 == 0 ? 0.0 : std::pow(10.0, rng.Uniform(-8.0, -0.1));
    for (int i = 1; i < 9; ++i) values[i] = values[0] + std::pow(10.0, rng.Uniform(-4.0, 0.0));
    const double scale = std::pow(10.0, rng.Uniform(-20.0, 20.0));
    Vector9 least, found;
    const Matrix9 matrix = scale * WithEigenvalues(values, rng, &least);
    REQUIRE(LeastEigenvector(matrix, &found));
    CHECK(found.norm() == Approx(1.0).epsilon(1e-12));
    const double gap = values.tail<8>().minCoeff() - values[0];
    CHECK(Error(found, least) < 1e-14 * values.sum() / gap + 1e-13);
  }
}

TEST_CASE("A plane of solutions, zero and values that are not finite are refused") {
  Rng rng(2);
  for (int trial = 0; trial < 100; ++trial) {
    Vector9 values = Vector9::Ones(), least, found;
    values.head(2 + trial % 7).setZero();
    CHECK_FALSE(LeastEigenvector(WithEigenvalues(values, rng, &least), &found));
  }
  Vector9 found;
  CHECK_FALSE(LeastEigenvector(Matrix9::Zero(), &found));
  CHECK_FALSE(LeastEigenvector(Matrix9::Constant(std::nan("")), &found));
  Matrix9 infinite = Matrix9::Identity();
  infinite(0, 0) = std::numeric_limits<double>::infinity();
  CHECK_FALSE(LeastEigenvector(infinite, &found));
}

}  // namespace
}  // namespace diffsac
