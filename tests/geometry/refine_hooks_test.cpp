// The models' Refine, as the sample-consensus loop calls it: it improves the truncated cost on all points, or leaves
// the model alone.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::HomographyPoints;
using testing::RandomHomography;
using testing::RandomProblem;

/// Σ min(residual², threshold²) over all points.
template <class Model>
double TruncatedCost(const PointMatrix& points, double threshold, const Matrix3Parameters& model) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double residual = Model::Residual(model, points.data() + 4 * i);
    sum += residual <= threshold ? residual * residual : threshold * threshold;
  }
  return sum;
}

struct Tally {
  int improved = 0;
  double before = 0.0, after = 0.0;
};

/// From models of minimal sets of inliers; every fifth point is an outlier.
template <class Model>
Tally RefineSets(const PointMatrix& points, double threshold, int trials, Rng& rng) {
  Tally tally;
  for (int trial = 0; trial < trials; ++trial) {
    int set[8];
    Matrix3Parameters models[Model::kMaxSolutions];
    rng.Distinct(static_cast<int>(points.rows()) / 5 * 4, Model::kMinimalSize, set);
    for (int i = 0; i < Model::kMinimalSize; ++i) set[i] += set[i] / 4 + 1;
    const int count = Model::SolveMinimal(points, set, models);
    for (int i = 0; i < count; ++i) {
      Matrix3Parameters refined = models[i];
      const bool moved = Model::Refine(points, threshold, &refined);
      const double before = TruncatedCost<Model>(points, threshold, models[i]);
      const double after = TruncatedCost<Model>(points, threshold, refined);
      CHECK(refined.norm() == Approx(1.0));
      if (moved) {
        CHECK(after < before);
      } else {
        CHECK(refined == models[i]);
      }
      tally.improved += moved ? 1 : 0;
      tally.before += before;
      tally.after += after;
    }
  }
  return tally;
}

void AddOutliers(PointMatrix* points, double low, double high, Rng& rng) {
  for (Eigen::Index i = 0; i < points->rows(); i += 5)
    for (int j = 0; j < 4; ++j) (*points)(i, j) = rng.Uniform(low, high);
}

TEST_CASE("Refine lowers the truncated cost on all points or leaves the model") {
  Rng rng(1);
  for (int scene = 0; scene < 5; ++scene) {
    auto problem = RandomProblem(100, rng, 0.7);
    PointMatrix plane = HomographyPoints(RandomHomography(rng), 100, rng, 0.7);
    const double focal = problem.k1(0, 0);
    AddOutliers(&problem.pixels, 0.0, 1000.0, rng);
    AddOutliers(&problem.normalized, -0.6, 0.6, rng);
    AddOutliers(&plane, 0.0, 1000.0, rng);
    for (const Tally& tally :
         {RefineSets<Fundamental>(problem.pixels, 2.0, 10, rng), RefineSets<Fundamental8>(problem.pixels, 2.0, 10, rng),
          RefineSets<Essential>(problem.normalized, 2.0 / focal, 10, rng),
          RefineSets<Homography>(plane, 2.0, 10, rng)}) {
      CHECK(tally.improved >= 5);
      CHECK(tally.after < 0.99 * tally.before);
    }
  }
}

TEST_CASE("Refine with weights of one is Refine; points of weight 0 are as good as gone, whatever the loss") {
  Rng rng(3);
  for (int trial = 0; trial < 10; ++trial) {
    auto problem = RandomProblem(100, rng, 0.3);
    Matrix3Parameters start = problem.fundamental;
    for (double& value : start) value *= 1.0 + 1e-4 * rng.Normal();
    const auto refined = [&](const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss) {
      Matrix3Parameters model = start;
      Fundamental::Refine(points, weights, loss, &model);
      return model;
    };
    const auto cost = [&](const Matrix3Parameters& model, const RobustLoss& loss) {
      double sum = 0.0;
      for (int i = 0; i < 100; ++i)
        sum += loss.Value(std::pow(Fundamental::Residual(model, problem.pixels.data() + 4 * i), 2));
      return sum;
    };
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(100);
    Matrix3Parameters truncated = start;
    Fundamental::Refine(problem.pixels, 2.0, &truncated);
    CHECK(refined(problem.pixels, ones, {LossKind::kTruncated, 2.0}) == truncated);
    for (const RobustLoss& loss :
         {RobustLoss{LossKind::kTruncated, 5.0}, RobustLoss{LossKind::kMarginalised, 8.0, 0.5}}) {
      const Matrix3Parameters model = refined(problem.pixels, ones, loss);
      CHECK(cost(model, loss) < cost(start, loss));
      PointMatrix more(120, 4);
      more << problem.pixels, problem.pixels.topRows(20).rowwise() + Eigen::RowVector4d(1.0, -1.0, -1.0, 2.0);
      Eigen::VectorXd weights = Eigen::VectorXd::Zero(120);
      weights.head(100).setConstant(1.0);
      CHECK(testing::FundamentalDistance(refined(more, weights, loss), model) < 1e-9);
    }
    CHECK(refined(problem.pixels, ones.head(50), {LossKind::kTruncated, 2.0}) == start);
  }
}

template <class Model>
void CheckHostile(const PointMatrix& points, const Matrix3Parameters& model) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  const auto unchanged = [](const PointMatrix& p, double threshold, Matrix3Parameters m) {
    Matrix3Parameters refined = m;
    const bool moved = Model::Refine(p, threshold, &refined);
    return !moved && (refined == m || !m.allFinite());
  };
  for (const double threshold : {0.0, -1.0, kNan, kInf}) CHECK(unchanged(points, threshold, model));
  for (int rows = 0; rows < 4; ++rows) CHECK(unchanged(points.topRows(rows), 1.0, model));
  CHECK(unchanged(points.leftCols<3>(), 1.0, model));
  CHECK(unchanged(points, 1.0, Matrix3Parameters::Constant(kNan)));
  CHECK(unchanged(points, 1.0, Matrix3Parameters::Zero()));
  Matrix3Parameters refined = model;
  Model::Refine(points.row(0).replicate(20, 1), 1.0, &refined);
  CHECK(refined.allFinite());
  PointMatrix bad = points;
  bad.setConstant(kNan);
  CHECK(unchanged(bad, 1.0, model));
  // A single value that is no number is a residual that is none: that point sits out.
  bad = points;
  bad(3, 1) = kNan;
  bad(5, 2) = kInf;
  refined = model;
  Model::Refine(bad, 1.0, &refined);
  CHECK(refined.allFinite());
}

TEST_CASE("Refine survives hostile input") {
  Rng rng(3);
  const auto problem = RandomProblem(30, rng, 0.5);
  const Matrix3Parameters h = RandomHomography(rng);
  CheckHostile<Fundamental>(problem.pixels, problem.fundamental);
  CheckHostile<Essential>(problem.normalized, problem.essential);
  CheckHostile<Homography>(HomographyPoints(h, 30, rng, 0.5), h);
}

/// Costs from a disturbed model by the number of steps that Refine may try.
template <class Model>
void CheckSteps(const PointMatrix& points, const Matrix3Parameters& start, const RobustLoss& loss) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(points.rows());
  const auto cost = [&](const Matrix3Parameters& model) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double residual = Model::Residual(model, points.data() + 4 * i);
      sum += loss.Value(residual * residual);
    }
    return sum;
  };
  Matrix3Parameters none = start;
  CHECK_FALSE(Model::Refine(points, ones, loss, &none, 0));
  CHECK(none == start);
  double last = cost(start);
  for (const int steps : {1, 2, 4, 25}) {
    CAPTURE(steps);
    Matrix3Parameters model = start;
    const bool moved = Model::Refine(points, ones, loss, &model, steps);
    CHECK(moved == (model != start));
    CHECK(cost(model) <= last * (1.0 + 1e-9));
    last = cost(model);
  }
  CHECK(last < cost(start));
  Matrix3Parameters untold = start, all = start;
  Model::Refine(points, ones, loss, &untold);
  Model::Refine(points, ones, loss, &all, kMostRefineSteps);
  CHECK(untold == all);
}

TEST_CASE("Refine tries as many steps as it is told, and more of them lower the cost further") {
  Rng rng(21);
  for (int trial = 0; trial < 20; ++trial) {
    const auto problem = RandomProblem(200, rng, 1.0);
    const auto disturbed = [&](const Matrix3Parameters& model) -> Matrix3Parameters {
      Matrix3Parameters other = model;
      for (double& value : other) value *= 1.0 + 1e-3 * rng.Normal();
      return other / other.norm();
    };
    CheckSteps<Fundamental>(problem.pixels, disturbed(problem.fundamental), {LossKind::kMarginalised, 20.0, 0.5});
    CheckSteps<Essential>(problem.normalized, disturbed(problem.essential), {LossKind::kMarginalised, 0.02, 5e-4});
    const Matrix3Parameters h = RandomHomography(rng);
    CheckSteps<Homography>(HomographyPoints(h, 200, rng, 1.0), disturbed(h), {LossKind::kTruncated, 20.0});
  }
}

}  // namespace
}  // namespace diffsac
