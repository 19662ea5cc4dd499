#include "diffsac/geometry/polynomial.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/null_space.h"

namespace diffsac {
namespace {

/// Coefficients of the product of (z - root).
std::vector<double> FromRoots(const std::vector<double>& roots) {
  std::vector<double> c = {1.0};
  for (const double root : roots) {
    std::vector<double> next(c.size() + 1, 0.0);
    for (std::size_t i = 0; i < c.size(); ++i) {
      next[i + 1] += c[i];
      next[i] -= root * c[i];
    }
    c = next;
  }
  return c;
}

std::vector<double> Multiply(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> c(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) c[i + j] += a[i] * b[j];
  return c;
}

TEST_CASE("The cubic's roots are found, simple and triple, and lower degrees") {
  Rng rng(1);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<double> expected = {rng.Uniform(-5, 5), rng.Uniform(-5, 5), rng.Uniform(-5, 5)};
    std::sort(expected.begin(), expected.end());
    if (expected[1] - expected[0] < 0.01 || expected[2] - expected[1] < 0.01) continue;
    std::vector<double> c = FromRoots(expected);
    const double factor = std::pow(10.0, rng.Uniform(-6, 6));
    for (double& value : c) value *= factor;
    double roots[3];
    REQUIRE(SolveCubic(c.data(), roots) == 3);
    for (int i = 0; i < 3; ++i) CHECK(roots[i] == Approx(expected[i]).margin(1e-9));
  }
  double roots[3];
  const double one_real[] = {-6.0, 1.0, 4.0, 1.0};  // (z - 1)(z² + 5z + 6)
  REQUIRE(SolveCubic(one_real, roots) == 3);
  CHECK(roots[0] == Approx(-3.0));
  CHECK(roots[1] == Approx(-2.0));
  CHECK(roots[2] == Approx(1.0));
  const double complex_pair[] = {-2.0, 1.0, -2.0, 1.0};  // (z - 2)(z² + 1)
  REQUIRE(SolveCubic(complex_pair, roots) == 1);
  CHECK(roots[0] == Approx(2.0));
  const double triple[] = {-1.0, 3.0, -3.0, 1.0};
  REQUIRE(SolveCubic(triple, roots) >= 1);
  CHECK(roots[0] == Approx(1.0).margin(1e-4));
  const double quadratic[] = {2.0, -3.0, 1.0, 0.0}, linear[] = {4.0, -2.0, 0.0, 0.0}, constant[] = {1.0, 0.0, 0.0, 0.0};
  REQUIRE(SolveCubic(quadratic, roots) == 2);
  CHECK(roots[0] == Approx(1.0));
  CHECK(roots[1] == Approx(2.0));
  REQUIRE(SolveCubic(linear, roots) == 1);
  CHECK(roots[0] == Approx(2.0));
  CHECK(SolveCubic(constant, roots) == 0);
  const double nan[] = {std::nan(""), 1.0, 1.0, 1.0};
  CHECK(SolveCubic(nan, roots) == 0);
}

TEST_CASE("Real roots of degree 10 are found among complex ones, near and far from zero") {
  Rng rng(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const int real = 2 * static_cast<int>(rng.Below(4));
    std::vector<double> expected;
    while (static_cast<int>(expected.size()) < real) {
      const double root = std::copysign(std::pow(10.0, rng.Uniform(-1.5, 1.5)), rng.Uniform(-1, 1));
      const bool apart = std::all_of(expected.begin(), expected.end(), [&](double other) {
        return std::abs(root - other) > 0.1 * std::max(std::abs(root), std::abs(other));
      });
      if (apart) expected.push_back(root);
    }
    std::vector<double> c = FromRoots(expected);
    while (c.size() < 11) {
      const double middle = rng.Uniform(-1, 1), height = rng.Uniform(0.3, 2.0);
      c = Multiply(c, {middle * middle + height * height, -2.0 * middle, 1.0});
    }
    std::vector<double> roots(10);
    REQUIRE(RealRoots10(c.data(), roots.data()) == real);
    roots.resize(real);
    std::sort(roots.begin(), roots.end());
    std::sort(expected.begin(), expected.end());
    for (int i = 0; i < real; ++i) CHECK(roots[i] == Approx(expected[i]).epsilon(1e-6));
  }
}

TEST_CASE("Ten real roots, vanishing leading coefficients and bad coefficients") {
  std::vector<double> c = FromRoots({-5, -4, -3, -2, -1, 1, 2, 3, 4, 5});
  std::vector<double> all(10);
  REQUIRE(RealRoots10(c.data(), all.data()) == 10);
  std::sort(all.begin(), all.end());
  for (int i = 0; i < 10; ++i) CHECK(all[i] == Approx(i < 5 ? i - 5.0 : i - 4.0).epsilon(1e-10));
  double roots[10];
  const double cubic[11] = {-6.0, 11.0, -6.0, 1.0};
  REQUIRE(RealRoots10(cubic, roots) == 3);
  const double quadratic[11] = {-2.0, -1.0, 1.0};
  REQUIRE(RealRoots10(quadratic, roots) == 2);
  CHECK(std::min(roots[0], roots[1]) == Approx(-1.0));
  CHECK(std::max(roots[0], roots[1]) == Approx(2.0));
  const double linear[11] = {3.0, -1.0};
  REQUIRE(RealRoots10(linear, roots) == 1);
  CHECK(roots[0] == 3.0);
  const double zero[11] = {}, constant[11] = {1.0};
  CHECK(RealRoots10(zero, roots) == 0);
  CHECK(RealRoots10(constant, roots) == 0);
  double bad[11] = {1.0, 1.0};
  bad[10] = std::nan("");
  CHECK(RealRoots10(bad, roots) == 0);
  const double even[11] = {-1.0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1.0};  // z¹⁰ = 1
  REQUIRE(RealRoots10(even, roots) == 2);
  CHECK(std::abs(roots[0]) == Approx(1.0));
}

TEST_CASE("Roots that rounding cannot separate end the search, wherever they are") {
  Rng rng(8);
  int near = 0, far = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const double root = rng.Uniform(-4.0, 4.0), next = root * (1.0 + 1e-15 * rng.Uniform(-1.0, 1.0));
    std::vector<double> c = FromRoots({root, next, root});
    if (trial % 2 == 0) c = Multiply(c, {1.0 + rng.Uniform(), 0.1, 1.0});
    c.resize(11);
    double roots[10];
    const int count = RealRoots10(c.data(), roots);
    CHECK(count <= 3);
    // A triple root is known to the cubic root of the rounding.
    for (int i = 0; i < count; ++i) ++(std::abs(roots[i] - root) < 2e-4 * (1.0 + std::abs(root)) ? near : far);
  }
  CHECK(near > 150);
  CHECK(far <= 5);
}

TEST_CASE("The orthogonal complement is orthonormal and orthogonal to the rows, dependent rows are refused") {
  Rng rng(3);
  for (int trial = 0; trial < 500; ++trial) {
    double rows[5][9], copy[5][9], basis[4][9];
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 9; ++j) rows[i][j] = copy[i][j] = rng.Normal() * std::pow(10.0, i - 2);
    REQUIRE(OrthogonalComplement(rows, basis));
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        double dot = 0.0;
        for (int j = 0; j < 9; ++j) dot += basis[a][j] * basis[b][j];
        CHECK(dot == Approx(a == b ? 1.0 : 0.0).margin(1e-14));
      }
      for (int i = 0; i < 5; ++i) {
        double dot = 0.0, length = 0.0;
        for (int j = 0; j < 9; ++j) {
          dot += basis[a][j] * copy[i][j];
          length += copy[i][j] * copy[i][j];
        }
        CHECK(std::abs(dot) < 1e-13 * std::sqrt(length));
      }
    }
    for (int j = 0; j < 9; ++j) copy[4][j] = copy[0][j] - 2.0 * copy[2][j];
    CHECK_FALSE(OrthogonalComplement(copy, basis));
  }
}

}  // namespace
}  // namespace diffsac
