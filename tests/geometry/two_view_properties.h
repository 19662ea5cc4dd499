#pragma once

// What all two-view models promise, as helpers for their tests.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/geometry/model.h"
#include "geometry/two_view_problems.h"

namespace diffsac::testing {

/// The first points, as rows of four values.
inline const double (*AsRows(const PointMatrix& points))[4] {
  return reinterpret_cast<const double(*)[4]>(points.data());
}

/// Residuals over columns are those of each point, bit for bit, whatever the range.
template <MinimalModel Model>
void CheckColumnResiduals(const Matrix3Parameters& model, const PointMatrix& points) {
  const Eigen::MatrixXd columns = points;
  const double* pointers[4];
  for (int i = 0; i < 4; ++i) pointers[i] = columns.col(i).data();
  const int count = static_cast<int>(points.rows());
  for (const int begin : {0, 1, 5}) {
    for (const int end : {begin, begin + 1, count - 2, count}) {
      std::vector<double> residuals(end - begin + 1, -1.0);
      Model::Residuals(model, pointers, begin, end, residuals.data());
      for (int i = begin; i < end; ++i) CHECK(residuals[i - begin] == Model::Residual(model, points.data() + 4 * i));
      CHECK(residuals.back() == -1.0);
    }
  }
}

/// Whatever the data: no crash, and every model that comes out is finite and of unit norm.
template <MinimalModel Model>
void CheckHostileInput() {
  constexpr int kSize = Model::kMinimalSize;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  Rng rng(99);
  std::vector<int> set(kSize);
  for (int i = 0; i < kSize; ++i) set[i] = i;
  typename Model::Parameters models[Model::kMaxSolutions];
  const auto run = [&](const PointMatrix& points) {
    const int found = Model::SolveMinimal(points, set.data(), models);
    REQUIRE(found <= Model::kMaxSolutions);
    for (int i = 0; i < found; ++i) {
      CHECK(models[i].allFinite());
      CHECK(models[i].norm() == Approx(1.0));
    }
    typename Model::Parameters fitted;
    const bool fits = Model::Fit(points, Eigen::VectorXd::Ones(points.rows()), &fitted);
    if (fits) CHECK(fitted.allFinite());
    return std::pair(found, fits);
  };
  PointMatrix random(20, 4);
  for (Eigen::Index i = 0; i < random.size(); ++i) random.data()[i] = rng.Uniform(0.0, 1.0);
  CHECK(Model::Determined(random));

  const PointMatrix equal = random.row(0).replicate(20, 1);
  CHECK(run(equal) == std::pair(0, false));
  CHECK_FALSE(Model::Determined(equal));

  PointMatrix collinear = random;
  for (int i = 0; i < 20; ++i) collinear.row(i).head<2>() << 0.1 * i, 0.2 * i + 1.0;
  CHECK(run(collinear) == std::pair(0, false));
  CHECK_FALSE(Model::Determined(collinear));
  for (int i = 0; i < 20; ++i) collinear.row(i).tail<2>() << -0.3 * i, 0.7 * i;
  CHECK(run(collinear) == std::pair(0, false));

  for (const double bad : {kNan, kInf, -kInf}) {
    PointMatrix broken = random;
    broken(2, 1) = bad;
    CHECK(run(broken) == std::pair(0, false));
    CHECK_FALSE(Model::Determined(broken));
    broken.setConstant(bad);
    CHECK(run(broken) == std::pair(0, false));
  }
  for (const double huge : {1e150, 1e300, 1e-150, 1e-300}) run(PointMatrix(huge * random));
  PointMatrix repeated = random;
  for (int i = 1; i < 20; ++i) repeated.row(i) = random.row(i % (kSize - 1));
  CHECK_FALSE(Model::Determined(repeated));
  CHECK(run(repeated).first == 0);
  PointMatrix still = random;
  still.rightCols<2>() = still.leftCols<2>();
  run(still);

  typename Model::Parameters model;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(20);
  CHECK_FALSE(Model::Fit(PointMatrix(0, 4), Eigen::VectorXd(0), &model));
  CHECK_FALSE(Model::Fit(random.topRows(1), Eigen::VectorXd::Ones(1), &model));
  CHECK_FALSE(Model::Fit(random.topRows(3), Eigen::VectorXd::Ones(3), &model));
  CHECK_FALSE(Model::Fit(random, Eigen::VectorXd::Zero(20), &model));
  CHECK_FALSE(Model::Fit(random, Eigen::VectorXd::Ones(19), &model));
  CHECK_FALSE(Model::Fit(random.leftCols<3>(), ones, &model));
  for (const double bad : {-1.0, kNan, kInf}) {
    Eigen::VectorXd weights = ones;
    weights[4] = bad;
    CHECK_FALSE(Model::Fit(random, weights, &model));
  }
  CHECK_FALSE(Model::Determined(PointMatrix(0, 4)));
  CHECK_FALSE(Model::Determined(random.topRows(kSize - 1)));
  CHECK_FALSE(Model::Determined(random.leftCols<3>()));
}

/// The same points in another unit: the same model, residuals in that unit.
template <MinimalModel Model>
void CheckScales(const PointMatrix& exact) {
  for (const double scale : {1e-8, 1e-3, 1e3, 1e8}) {
    CAPTURE(scale);
    const PointMatrix points = scale * exact;
    typename Model::Parameters model, models[Model::kMaxSolutions];
    REQUIRE(Model::Fit(points, Eigen::VectorXd::Ones(points.rows()), &model));
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      CHECK(Model::Residual(model, points.data() + 4 * i) < 1e-7 * scale);
    CHECK(Model::Determined(points));
    std::vector<int> set(Model::kMinimalSize);
    for (int i = 0; i < Model::kMinimalSize; ++i) set[i] = i;
    const int found = Model::SolveMinimal(points, set.data(), models);
    REQUIRE(found >= 1);
    double best = 1e300;
    for (int k = 0; k < found; ++k) {
      double worst = 0.0;
      for (Eigen::Index i = 0; i < points.rows(); ++i)
        worst = std::max(worst, Model::Residual(models[k], points.data() + 4 * i));
      best = std::min(best, worst);
    }
    CHECK(best < 1e-6 * scale);
  }
}

/// Integer weights are repeated points; a common factor of the weights does not matter.
template <MinimalModel Model>
void CheckWeightsAreRepetitions(const PointMatrix& points, Rng& rng) {
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::VectorXd weights(points.rows());
    for (double& weight : weights) weight = static_cast<double>(rng.Below(4));
    PointMatrix repeated(static_cast<Eigen::Index>(weights.sum()), 4);
    Eigen::Index row = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      for (int copy = 0; copy < weights[i]; ++copy) repeated.row(row++) = points.row(i);
    typename Model::Parameters weighted, plain, scaled;
    REQUIRE(Model::Fit(points, weights, &weighted));
    REQUIRE(Model::Fit(repeated, Eigen::VectorXd::Ones(row), &plain));
    REQUIRE(Model::Fit(points, 1e-7 * weights, &scaled));
    CHECK(ModelDistance(weighted, plain) < 1e-8);
    CHECK(ModelDistance(weighted, scaled) < 1e-8);
  }
}

}  // namespace diffsac::testing
