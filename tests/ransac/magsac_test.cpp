#include "diffsac/ransac/scores/magsac.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/ransac/model_hooks.h"

namespace diffsac {
namespace {

/// Tanh-sinh quadrature over (low, high): exact to nearly double precision, singular ends included.
double Integrate(const std::function<double(double)>& f, double low, double high) {
  const double half = 0.5 * (high - low), step = 1.0 / 24.0;
  double sum = 0.0;
  for (int i = -24 * 4; i <= 24 * 4; ++i) {
    const double t = i * step, u = 0.5 * 3.14159265358979323846 * std::sinh(t);
    const double weight = 0.5 * 3.14159265358979323846 * std::cosh(t) / (std::cosh(u) * std::cosh(u));
    // Distances from the nearer end keep their digits where the integrand is singular.
    const double from_end = half * std::exp(-std::abs(u)) / std::cosh(u);
    const double x = u < 0.0 ? low + from_end : high - from_end;
    if (x > low && x < high) sum += weight * f(x);
  }
  return sum * step * half;
}

/// The density of χ with n degrees of freedom and scale σ.
double ChiDensity(double r, double sigma, int dof) {
  const double constant = 2.0 / (std::pow(2.0, 0.5 * dof) * std::tgamma(0.5 * dof));
  return constant * std::pow(r, dof - 1) * std::pow(sigma, -dof) * std::exp(-0.5 * r * r / (sigma * sigma));
}

TEST_CASE("The quantiles are those of the chi distribution, and of the published code to three digits") {
  const double published[] = {3.034798, 3.367492, 3.644173, 3.884585, 4.1};
  for (int dof = 1; dof <= 6; ++dof) {
    const double quantile = ChiQuantile99(dof);
    CHECK(Integrate([&](double r) { return ChiDensity(r, 1.0, dof); }, 0.0, quantile) == Approx(0.99).epsilon(1e-10));
    if (dof >= 2) CHECK(quantile == Approx(published[dof - 2]).margin(1e-3));
  }
  CHECK_THROWS_AS(ChiQuantile99(0), Error);
  CHECK_THROWS_AS(ChiQuantile99(7), Error);
  CHECK_THROWS_AS(MagsacScoreTable(7), Error);
}

TEST_CASE("The weight is the density marginalised over sigma, the loss its integral") {
  const double threshold = 0.7;
  for (int dof = 1; dof <= 6; ++dof) {
    const double k = ChiQuantile99(dof), sigma_max = threshold / k;
    const auto marginal = [&](double r) {
      return Integrate([&](double sigma) { return ChiDensity(r, sigma, dof); }, r / k, sigma_max) / sigma_max;
    };
    const auto loss = [&](double r) { return Integrate([&](double s) { return s * marginal(s); }, 0.0, r); };
    const MagsacLoss magsac(threshold, dof);
    const double total = loss(threshold);
    for (double share : {0.05, 0.3, 0.6, 0.95}) {
      CAPTURE(dof, share);
      const double r = share * threshold;
      CHECK(magsac.Score(r) == Approx(1.0 - loss(r) / total).margin(1e-7));
      CHECK(magsac.ExactWeight(r) / (threshold * threshold) == Approx(marginal(r) / total).epsilon(1e-6));
      CHECK(magsac.Weight(r) == magsac.ExactWeight(r));
    }
  }
}

TEST_CASE("The table is within 1e-6 of the loss") {
  for (int dof = 1; dof <= 6; ++dof) {
    const double* table = MagsacScoreTable(dof);
    const MagsacLoss loss(1.0, dof);
    double worst = 0.0;
    for (int i = 0; i < kMagsacTableSize; ++i)
      for (double part : {0.25, 0.5, 0.75}) {
        const double interpolated = table[i] + part * (table[i + 1] - table[i]);
        worst = std::max(worst, std::abs(interpolated - loss.Score((i + part) / kMagsacTableSize)));
      }
    CAPTURE(dof, worst);
    CHECK(worst < 1e-6);
  }
}

TEST_CASE("Weights are finite and end at the threshold") {
  for (int dof = 1; dof <= 6; ++dof) {
    const MagsacLoss loss(2.0, dof);
    CHECK(std::isfinite(loss.Weight(0.0)));
    CHECK(loss.Weight(0.0) > loss.Weight(1.0));
    CHECK(loss.Weight(2.0) == 0.0);
    CHECK(loss.Weight(1e300) == 0.0);
    CHECK(loss.Weight(std::numeric_limits<double>::quiet_NaN()) == 0.0);
  }
  CHECK(std::isinf(MagsacLoss(2.0, 1).ExactWeight(0.0)));
}

TEST_CASE("A Sampson distance has the degrees of freedom that MAGSAC++ reckons with") {
  const double sigma = 0.7;
  const Eigen::Matrix3d f = (Eigen::Matrix3d() << 0, -1e-6, 2e-3, 2e-6, 0, -4e-3, -3e-3, 5e-3, 0.4).finished();
  const Matrix3Parameters model = Eigen::Map<const Matrix3Parameters>(Eigen::Matrix3d(f.transpose()).data());
  Rng rng(5);
  double sum = 0.0;
  const int count = 20000;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d x1(1000 * rng.Uniform(), 1000 * rng.Uniform(), 1.0), line = f * x1;
    const double x2 = 1000 * rng.Uniform(), y2 = -(line[0] * x2 + line[2]) / line[1];
    const double point[4] = {x1[0] + sigma * rng.Normal(), x1[1] + sigma * rng.Normal(), x2 + sigma * rng.Normal(),
                             y2 + sigma * rng.Normal()};
    sum += std::pow(Fundamental::Residual(model, point) / sigma, 2);
  }
  // The mean of chi squared is its degrees of freedom.
  CHECK(sum / count == Approx(ResidualDof<Fundamental>()).epsilon(0.04));
  CHECK(ResidualDof<Essential>() == ResidualDof<Fundamental>());
  CHECK(ResidualDof<Fundamental8>() == ResidualDof<Fundamental>());
}

}  // namespace
}  // namespace diffsac
