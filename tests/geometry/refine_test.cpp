#include "diffsac/geometry/refine.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/manifolds.h"
#include "diffsac/geometry/sampson_equations.h"
#include "geometry/jacobian_check.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::CheckJacobian;
using testing::HomographyPoints;
using testing::ModelDistance;
using testing::RandomHomography;
using testing::RandomProblem;

constexpr LossKind kLosses[] = {LossKind::kTrivial, LossKind::kTruncated, LossKind::kHuber, LossKind::kCauchy};

TEST_CASE("The Sampson residual's gradient by F is exact") {
  Rng rng(1);
  for (int trial = 0; trial < 200; ++trial) {
    const auto problem = RandomProblem(1, rng);
    Eigen::Vector4d point = problem.normalized.row(0).transpose();
    for (double& value : point) value += 0.05 * rng.Normal();
    Matrix3Parameters f = problem.essential;
    for (double& value : f) value += 0.02 * rng.Normal();
    Eigen::RowVectorXd gradient(9);
    const double r = SampsonResidual(f.data(), point.data(), gradient.data());
    CHECK(std::abs(r) == Approx(SampsonError(f, point.data())).epsilon(1e-12));
    CheckJacobian(
        [&](const Eigen::VectorXd& x) {
          return Eigen::VectorXd::Constant(1, SampsonResidual(x.data(), point.data(), nullptr));
        },
        f, gradient);
  }
}

TEST_CASE("The sums of the normal equations are those of the single residuals") {
  Rng rng(10);
  for (const int count : {1, 3, 4, 7, 31, 32, 33, 64, 99}) {
    const auto problem = RandomProblem(count, rng, 2.0);
    const Eigen::MatrixXd columns = problem.normalized;
    const double* pointers[4];
    for (int j = 0; j < 4; ++j) pointers[j] = columns.col(j).data();
    Eigen::VectorXd weights(count);
    for (double& weight : weights) weight = rng.Below(3) == 0 ? 0.0 : rng.Uniform();
    Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
    Matrix3Parameters pull = Matrix3Parameters::Zero(), gradient;
    for (int i = 0; i < count; ++i) {
      const double r = SampsonResidual(problem.essential.data(), problem.normalized.data() + 4 * i, gradient.data());
      normal += weights[i] * gradient * gradient.transpose();
      pull += weights[i] * r * gradient;
    }
    const NormalEquations sums = SumSampsonEquations(problem.essential.data(), pointers, weights.data(), count);
    CHECK((sums.normal - normal).norm() <= 1e-13 * (1.0 + normal.norm()));
    CHECK((sums.gradient - pull).norm() <= 1e-13 * (1.0 + pull.norm()));
  }
}

template <class Manifold>
void CheckManifold(const std::function<Matrix3Parameters()>& random_model) {
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix3Parameters model = random_model();
    const Manifold state = Manifold::From(model);
    CHECK(ModelDistance(state.Parameters(), model) < 1e-13);
    CHECK(state.Parameters().norm() == Approx(1.0).epsilon(1e-13));
    const Eigen::Matrix<double, 9, Manifold::kFreedom> tangent = state.Tangent();
    CheckJacobian([&](const Eigen::VectorXd& step) -> Eigen::VectorXd { return state.Retract(step).Parameters(); },
                  Eigen::VectorXd::Zero(Manifold::kFreedom), tangent);
    CHECK((tangent.transpose() * state.Parameters()).norm() < 1e-13);  // the norm stays
  }
}

TEST_CASE("Manifolds: models are on them, tangents are exact, steps stay on them") {
  Rng rng(3);
  CheckManifold<HomographyManifold>([&] { return RandomHomography(rng); });
  CheckManifold<FundamentalManifold>([&] { return RandomProblem(1, rng).fundamental; });
  CheckManifold<EssentialManifold>([&] { return RandomProblem(1, rng).essential; });
  for (int trial = 0; trial < 100; ++trial) {
    const auto problem = RandomProblem(1, rng);
    Eigen::Matrix<double, 7, 1> step7;
    for (double& value : step7) value = rng.Normal();
    const Matrix3Parameters f = FundamentalManifold::From(problem.fundamental).Retract(step7).Parameters();
    CHECK(std::abs(AsMatrix(f).determinant()) < 1e-15);
    const Matrix3Parameters e = EssentialManifold::From(problem.essential).Retract(step7.head<5>()).Parameters();
    CHECK((ClosestEssential(AsMatrix(e)) - AsMatrix(e)).norm() < 1e-14);
    CHECK(f.norm() == Approx(1.0));
    CHECK(e.norm() == Approx(1.0));
  }
}

/// One refinement task of any model, so that the promises are checked alike.
struct Task {
  const char* name;
  double unit;  ///< a pixel, in the points' unit
  std::function<RefineReport(const PointMatrix&, const Eigen::VectorXd&, const RefineOptions&, Matrix3Parameters*)>
      refine;
  std::function<double(const Matrix3Parameters&, const double*)> residual;
  /// exact points, the true model
  std::function<std::pair<PointMatrix, Matrix3Parameters>(int, Rng&)> make;
  std::function<bool(const PointMatrix&, const Eigen::VectorXd&, Matrix3Parameters*)> fit;
  std::function<double(const Matrix3Parameters&, const Matrix3Parameters&)> distance;
};

std::vector<Task> Tasks() {
  const auto homography = [](int count, Rng& rng) {
    const Matrix3Parameters truth = RandomHomography(rng);
    return std::pair(HomographyPoints(truth, count, rng), truth);
  };
  return {
      {"homography", 1.0, RefineHomography, HomographySampsonError, homography, Homography::Fit,
       testing::HomographyDistance},
      {"fundamental", 1.0, RefineFundamental, SampsonError,
       [](int count, Rng& rng) {
         const auto problem = RandomProblem(count, rng);
         return std::pair(problem.pixels, problem.fundamental);
       },
       Fundamental::Fit, testing::FundamentalDistance},
      {"essential", 1e-3, RefineEssential, SampsonError,
       [](int count, Rng& rng) {
         const auto problem = RandomProblem(count, rng);
         return std::pair(problem.normalized, problem.essential);
       },
       Essential::Fit, ModelDistance},
  };
}

PointMatrix Noisy(const PointMatrix& points, double sigma, Rng& rng) {
  PointMatrix noisy = points;
  for (Eigen::Index i = 0; i < noisy.size(); ++i) noisy.data()[i] += sigma * rng.Normal();
  return noisy;
}

double Cost(const Task& task, const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
            const Matrix3Parameters& model) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double r = task.residual(model, points.data() + 4 * i);
    if (weights[i] > 0.0) sum += weights[i] * loss.Value(r * r);
  }
  return sum;
}

TEST_CASE("Refinement lowers the cost it reports, for every model and loss, with weights and outliers") {
  Rng rng(4);
  for (const Task& task : Tasks()) {
    for (const LossKind kind : kLosses) {
      CAPTURE(task.name, static_cast<int>(kind));
      for (int trial = 0; trial < 10; ++trial) {
        const auto [exact, truth] = task.make(60, rng);
        PointMatrix points = Noisy(exact, task.unit, rng);
        for (int i = 0; i < 6; ++i) points(i, 2) += 40.0 * task.unit * rng.Normal();
        Eigen::VectorXd weights(60);
        for (double& weight : weights) weight = rng.Uniform(0.2, 2.0);
        weights.tail<4>().setZero();
        points(59, 0) = std::nan("");  // of no weight
        Matrix3Parameters start, model;
        REQUIRE(task.fit(points, weights, &start));
        model = start;
        RefineOptions options;
        options.loss = {kind, 3.0 * task.unit};
        options.max_iterations = 50;
        const RefineReport report = task.refine(points, weights, options, &model);
        REQUIRE(report.status == Status::kOk);
        CHECK(report.final_cost <= report.initial_cost);
        CHECK(report.iterations >= 1);
        CHECK(report.iterations <= 50);
        CHECK(report.initial_cost == Approx(Cost(task, points, weights, options.loss, start)).epsilon(1e-6));
        CHECK(report.final_cost == Approx(Cost(task, points, weights, options.loss, model)).epsilon(1e-6));
        CHECK(model.norm() == Approx(1.0));
        // A second run from the result finds nothing more to speak of.
        Matrix3Parameters again = model;
        const RefineReport second = task.refine(points, weights, options, &again);
        CHECK(second.final_cost <= report.final_cost * (1.0 + 1e-9));
        CHECK(second.final_cost >= report.final_cost * (1.0 - 1e-3));
      }
    }
  }
}

TEST_CASE("From a disturbed start, exact points bring back the exact model") {
  Rng rng(5);
  for (const Task& task : Tasks()) {
    CAPTURE(task.name);
    int recovered = 0;
    for (int trial = 0; trial < 100; ++trial) {
      const auto [points, truth] = task.make(40, rng);
      const PointMatrix noisy = Noisy(points, 2.0 * task.unit, rng);
      const Eigen::VectorXd ones = Eigen::VectorXd::Ones(40);
      Matrix3Parameters model;
      REQUIRE(task.fit(noisy, ones, &model));
      RefineOptions options;
      options.loss.kind = LossKind::kTrivial;
      options.max_iterations = 100;
      const RefineReport report = task.refine(points, ones, options, &model);
      recovered += report.final_cost < 1e-16 * task.unit * task.unit && task.distance(model, truth) < 1e-7 ? 1 : 0;
    }
    CHECK(recovered >= 97);
  }
}

TEST_CASE("Refinement comes nearer to the truth than the linear fit") {
  Rng rng(6);
  for (const Task& task : Tasks()) {
    double linear = 0.0, refined = 0.0;
    for (int trial = 0; trial < 100; ++trial) {
      const auto [exact, truth] = task.make(60, rng);
      const PointMatrix points = Noisy(exact, task.unit, rng);
      const Eigen::VectorXd ones = Eigen::VectorXd::Ones(60);
      const auto error = [&, exact = exact](const Matrix3Parameters& model) {
        double sum = 0.0;
        for (int i = 0; i < 60; ++i) sum += task.residual(model, exact.data() + 4 * i);
        return sum;
      };
      Matrix3Parameters model;
      REQUIRE(task.fit(points, ones, &model));
      linear += error(model);
      RefineOptions options;
      options.loss = {LossKind::kTrivial, 1.0};
      REQUIRE(task.refine(points, ones, options, &model).status == Status::kOk);
      refined += error(model);
    }
    CAPTURE(task.name, linear, refined);
    CHECK(refined < linear);
  }
}

TEST_CASE("A robust loss keeps gross outliers from moving the model") {
  Rng rng(7);
  for (const Task& task : Tasks()) {
    for (const LossKind kind : {LossKind::kTruncated, LossKind::kCauchy}) {
      CAPTURE(task.name, static_cast<int>(kind));
      int close = 0;
      for (int trial = 0; trial < 30; ++trial) {
        const auto [exact, truth] = task.make(100, rng);
        PointMatrix points = exact;
        for (int i = 0; i < 20; ++i)
          for (int j = 2; j < 4; ++j) points(i, j) += 100.0 * task.unit * rng.Normal();
        // The start: fitted to slightly noisy inliers.
        Matrix3Parameters model;
        Eigen::VectorXd weights = Eigen::VectorXd::Ones(100);
        weights.head<20>().setZero();
        REQUIRE(task.fit(Noisy(exact, 0.2 * task.unit, rng), weights, &model));
        RefineOptions options;
        options.loss = {kind, (kind == LossKind::kTruncated ? 2.0 : 0.02) * task.unit};
        options.max_iterations = 100;
        task.refine(points, Eigen::VectorXd::Ones(100), options, &model);
        double worst = 0.0;
        for (int i = 20; i < 100; ++i) worst = std::max(worst, task.residual(model, points.data() + 4 * i));
        close += worst < 0.05 * task.unit ? 1 : 0;
      }
      CHECK(close >= (kind == LossKind::kTruncated ? 20 : 27));
    }
  }
}

TEST_CASE("Pixels in other units refine to the same model") {
  Rng rng(8);
  for (const Task& task : Tasks()) {
    if (task.unit != 1.0) continue;  // E lives in normalised coordinates only
    CAPTURE(task.name);
    const auto [exact, truth] = task.make(50, rng);
    const PointMatrix points = Noisy(exact, 1.0, rng);
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(50);
    double reference = 0.0;
    for (const double scale : {1.0, 1e-8, 1e8}) {
      const PointMatrix scaled = scale * points;
      Matrix3Parameters model;
      REQUIRE(task.fit(scaled, ones, &model));
      RefineOptions options;
      options.loss = {LossKind::kCauchy, 2.0 * scale};
      const RefineReport report = task.refine(scaled, ones, options, &model);
      REQUIRE(report.status == Status::kOk);
      if (scale == 1.0) reference = report.final_cost;
      CHECK(report.final_cost / (scale * scale) == Approx(reference).epsilon(1e-6));
    }
  }
}

TEST_CASE("Bad input leaves the model as it was and is typed") {
  Rng rng(9);
  for (const Task& task : Tasks()) {
    CAPTURE(task.name);
    const auto [points, truth] = task.make(20, rng);
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(20);
    const auto status = [&, truth = truth](const PointMatrix& p, const Eigen::VectorXd& w) {
      Matrix3Parameters model = truth;
      const RefineReport report = task.refine(p, w, RefineOptions(), &model);
      CHECK(model == truth);
      return report.status;
    };
    CHECK(status(PointMatrix(0, 4), Eigen::VectorXd(0)) == Status::kTooFewPoints);
    CHECK(status(points.topRows(3), ones.head(3)) == Status::kTooFewPoints);
    CHECK(status(points, Eigen::VectorXd::Zero(20)) == Status::kTooFewPoints);
    CHECK(status(points, ones.head(19)) == Status::kDegenerate);
    CHECK(status(points, -ones) == Status::kDegenerate);
    CHECK(status(points.leftCols<3>(), ones) == Status::kDegenerate);
    PointMatrix bad = points;
    bad(3, 3) = std::nan("");
    CHECK(status(bad, ones) == Status::kDegenerate);
    Matrix3Parameters nan = Matrix3Parameters::Constant(std::nan("")), zero = Matrix3Parameters::Zero();
    CHECK(task.refine(points, ones, RefineOptions(), &nan).status == Status::kDegenerate);
    CHECK(task.refine(points, ones, RefineOptions(), &zero).status == Status::kDegenerate);
    Matrix3Parameters model = truth;
    RefineOptions none;
    none.max_iterations = 0;
    CHECK(task.refine(points, ones, none, &model).iterations == 0);
    CHECK(model == truth);
  }
}

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

template <class Model>
bool Refine(const PointMatrix& points, double threshold, Matrix3Parameters* model) {
  return Model::Refine(points, Eigen::VectorXd::Ones(points.rows()), {LossKind::kTruncated, threshold}, model);
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
      const bool moved = Refine<Model>(points, threshold, &refined);
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

TEST_CASE("Refine lowers any loss, and points of weight 0 are as good as gone") {
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
    const bool moved = Refine<Model>(p, threshold, &refined);
    return !moved && (refined == m || !m.allFinite());
  };
  for (const double threshold : {0.0, -1.0, kNan, kInf}) CHECK(unchanged(points, threshold, model));
  for (int rows = 0; rows < 4; ++rows) CHECK(unchanged(points.topRows(rows), 1.0, model));
  CHECK(unchanged(points.leftCols<3>(), 1.0, model));
  CHECK(unchanged(points, 1.0, Matrix3Parameters::Constant(kNan)));
  CHECK(unchanged(points, 1.0, Matrix3Parameters::Zero()));
  Matrix3Parameters refined = model;
  Refine<Model>(points.row(0).replicate(20, 1), 1.0, &refined);
  CHECK(refined.allFinite());
  PointMatrix bad = points;
  bad.setConstant(kNan);
  CHECK(unchanged(bad, 1.0, model));
  // A single value that is no number is a residual that is none: that point sits out.
  bad = points;
  bad(3, 1) = kNan;
  bad(5, 2) = kInf;
  refined = model;
  Refine<Model>(bad, 1.0, &refined);
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
