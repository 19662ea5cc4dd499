#include "diffsac/geometry/hyperplane.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <catch2/catch.hpp>
#include <limits>
#include <numeric>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

PointMatrix RandomPoints(int count, int dimension, double half_width, Rng& rng) {
  PointMatrix points(count, dimension);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = rng.Uniform(-half_width, half_width);
  return points;
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <int D>
using Parameters = typename Hyperplane<D>::Parameters;

/// Largest difference of the parameters, whichever sign the model has.
double Difference(const ModelParameters& a, const ModelParameters& b) {
  return std::min((a - b).cwiseAbs().maxCoeff(), (a + b).cwiseAbs().maxCoeff());
}

/// A random orthogonal matrix.
Eigen::MatrixXd RandomRotation(int dimension, Rng& rng) {
  Eigen::MatrixXd random(dimension, dimension);
  for (Eigen::Index i = 0; i < random.size(); ++i) random.data()[i] = rng.Normal();
  return random.householderQr().householderQ() * Eigen::MatrixXd::Identity(dimension, dimension);
}

TEMPLATE_TEST_CASE_SIG("Minimal models of 10 000 random problems are the true ones", "", ((int D), D), 2, 3) {
  Rng rng(11);
  int solved = 0, recovered = 0, precise = 0, set[D];
  std::iota(set, set + D, 0);
  for (int trial = 0; trial < 10000; ++trial) {
    Parameters<D> truth, model;
    for (int j = 0; j < D; ++j) truth[j] = rng.Normal();
    truth[D] = rng.Uniform(-100.0, 100.0);
    truth /= truth.template head<D>().norm();
    PointMatrix points = RandomPoints(D, D, 10.0, rng);
    for (int i = 0; i < D; ++i)
      points.row(i) -= (points.row(i).dot(truth.template head<D>()) + truth[D]) * truth.template head<D>().transpose();
    if (Hyperplane<D>::SolveMinimal(points, set, &model) != 1) continue;
    ++solved;
    recovered += Difference(model, truth) < 1e-8 ? 1 : 0;
    precise += Difference(model, truth) < 1e-12 ? 1 : 0;
  }
  CAPTURE(solved, recovered, precise);
  CHECK(solved == 10000);
  CHECK(recovered >= 9990);  // what is lost are points that nearly coincide or nearly lie on a line
  CHECK(precise >= 9000);
}

TEST_CASE("Minimal models with known answers") {
  PointMatrix line(2, 2);
  line << 0, 1, 4, 1;
  const int pair[] = {0, 1};
  Line::Parameters model;
  REQUIRE(Line::SolveMinimal(line, pair, &model) == 1);
  CHECK(Difference(model, Eigen::Vector3d(0, 1, -1)) < 1e-15);

  PointMatrix plane(3, 3);
  plane << 1, 0, 0, 0, 1, 0, 0, 0, 1;
  const int triplet[] = {0, 1, 2};
  Plane::Parameters solved;
  REQUIRE(Plane::SolveMinimal(plane, triplet, &solved) == 1);
  CHECK(Difference(solved, Eigen::Vector4d(1, 1, 1, -1) / std::sqrt(3.0)) < 1e-15);
}

TEST_CASE("Degenerate minimal sets give no model") {
  for (double scale : {1e-6, 1.0, 1e6}) {
    CAPTURE(scale);
    PointMatrix points(4, 2);
    points << 1, 2, 1, 2, 3, 4, kNan, 0;
    points *= scale;
    Line::Parameters line;
    const int equal[] = {0, 1}, good[] = {0, 2}, nan[] = {2, 3};
    CHECK(Line::SolveMinimal(points, equal, &line) == 0);
    CHECK(Line::SolveMinimal(points, good, &line) == 1);
    CHECK(Line::SolveMinimal(points, nan, &line) == 0);

    PointMatrix space(5, 3);
    space << 1, 2, 3, 2, 3, 4, 5, 6, 7, 1, 0, 0, kNan, 0, 0;
    space *= scale;
    Plane::Parameters plane;
    const int collinear[] = {0, 1, 2}, twice[] = {0, 0, 3}, spans[] = {0, 1, 3}, bad[] = {0, 1, 4};
    CHECK(Plane::SolveMinimal(space, collinear, &plane) == 0);
    CHECK(Plane::SolveMinimal(space, twice, &plane) == 0);
    CHECK(Plane::SolveMinimal(space, spans, &plane) == 1);
    CHECK(Plane::SolveMinimal(space, bad, &plane) == 0);
  }
}

TEST_CASE("Points whose squares overflow give no model rather than a wrong one") {
  PointMatrix points(2, 2);
  points << -1e300, 0, 1e300, 1e300;
  const int set[] = {0, 1};
  Line::Parameters line;
  if (Line::SolveMinimal(points, set, &line) == 1) CHECK(line.allFinite());
  if (Line::Fit(points, Eigen::VectorXd::Ones(2), &line)) CHECK(line.allFinite());
}

TEMPLATE_TEST_CASE_SIG("A fit turns and moves with its points", "", ((int D), D), 2, 3) {
  Rng rng(2);
  for (int trial = 0; trial < 200; ++trial) {
    const PointMatrix points = RandomPoints(12, D, 3.0, rng);
    Eigen::VectorXd weights(12);
    for (double& weight : weights) weight = rng.Uniform(0.1, 1.0);
    const Eigen::MatrixXd rotation = RandomRotation(D, rng);
    const Eigen::RowVectorXd shift = RandomPoints(1, D, 5.0, rng);
    const PointMatrix moved = (points * rotation.transpose()).rowwise() + shift;
    Parameters<D> model, moved_model;
    REQUIRE(Hyperplane<D>::Fit(points, weights, &model));
    REQUIRE(Hyperplane<D>::Fit(moved, weights, &moved_model));
    Parameters<D> expected;
    expected.template head<D>() = rotation * model.template head<D>();
    expected[D] = model[D] - expected.template head<D>().dot(shift.transpose());
    CHECK(Difference(moved_model, expected) < 1e-9);
  }
}

TEMPLATE_TEST_CASE_SIG("Integer weights are repeated points, and the weights' scale does not matter", "", ((int D), D),
                       2, 3) {
  Rng rng(3);
  for (int trial = 0; trial < 200; ++trial) {
    const PointMatrix points = RandomPoints(9, D, 3.0, rng);
    Eigen::VectorXd weights(9);
    for (double& weight : weights) weight = static_cast<double>(rng.Below(4));
    if ((weights.array() > 0.0).count() <= D) continue;
    PointMatrix repeated(static_cast<Eigen::Index>(weights.sum()), D);
    Eigen::Index row = 0;
    for (Eigen::Index i = 0; i < 9; ++i)
      for (int copy = 0; copy < weights[i]; ++copy) repeated.row(row++) = points.row(i);
    Parameters<D> weighted, plain, scaled;
    REQUIRE(Hyperplane<D>::Fit(points, weights, &weighted));
    REQUIRE(Hyperplane<D>::Fit(repeated, Eigen::VectorXd::Ones(row), &plain));
    REQUIRE(Hyperplane<D>::Fit(points, 1e-7 * weights, &scaled));
    CHECK(Difference(weighted, plain) < 1e-10);
    CHECK(Difference(weighted, scaled) < 1e-10);
  }
}

TEMPLATE_TEST_CASE_SIG("No nearby hyperplane has a smaller weighted sum of squared residuals", "", ((int D), D), 2, 3) {
  Rng rng(4);
  const auto cost = [](const PointMatrix& points, const Eigen::VectorXd& weights, const Parameters<D>& model) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      sum += weights[i] * std::pow(Hyperplane<D>::Residual(model, points.data() + i * D), 2);
    return sum;
  };
  for (int trial = 0; trial < 100; ++trial) {
    const PointMatrix points = RandomPoints(15, D, 2.0, rng);
    Eigen::VectorXd weights(15);
    for (double& weight : weights) weight = rng.Uniform();
    Parameters<D> model;
    REQUIRE(Hyperplane<D>::Fit(points, weights, &model));
    const double best = cost(points, weights, model);
    for (int step = 0; step < 20; ++step) {
      Parameters<D> other = model;
      for (double& value : other) value += 0.01 * rng.Normal();
      other /= other.template head<D>().norm();
      CHECK(cost(points, weights, other) >= best - 1e-12);
    }
  }
}

TEMPLATE_TEST_CASE_SIG("Fits without a unique answer are refused", "", ((int D), D), 2, 3) {
  Rng rng(5);
  Parameters<D> model;
  const PointMatrix points = RandomPoints(8, D, 1.0, rng);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(8);
  CHECK_FALSE(Hyperplane<D>::Fit(points, Eigen::VectorXd::Zero(8), &model));
  CHECK_FALSE(Hyperplane<D>::Fit(points, Eigen::VectorXd::Ones(7), &model));
  Eigen::VectorXd few = Eigen::VectorXd::Zero(8);
  few.head(D - 1).setOnes();
  CHECK_FALSE(Hyperplane<D>::Fit(points, few, &model));
  Eigen::VectorXd negative = ones, nan = ones, infinite = ones;
  negative[3] = -1.0;
  nan[3] = kNan;
  infinite[3] = std::numeric_limits<double>::infinity();
  CHECK_FALSE(Hyperplane<D>::Fit(points, negative, &model));
  CHECK_FALSE(Hyperplane<D>::Fit(points, nan, &model));
  CHECK_FALSE(Hyperplane<D>::Fit(points, infinite, &model));
  CHECK_FALSE(Hyperplane<D>::Fit(PointMatrix(points.row(0).replicate(8, 1)), ones, &model));
  PointMatrix bad = points;
  bad(2, 1) = kNan;
  CHECK_FALSE(Hyperplane<D>::Fit(bad, ones, &model));
  Eigen::VectorXd without = ones;
  without[2] = 0.0;
  CHECK(Hyperplane<D>::Fit(bad, without, &model));
  CHECK_FALSE(Hyperplane<D>::Fit(PointMatrix(0, D), Eigen::VectorXd(0), &model));
}

TEST_CASE("Plane fits agree with a singular value decomposition, also far from the origin and for thin noise") {
  Rng rng(12);
  for (double noise : {1e-6, 0.05, 0.5}) {
    for (double distance : {0.0, 1000.0}) {
      CAPTURE(noise, distance);
      for (int trial = 0; trial < 50; ++trial) {
        PointMatrix points = RandomPoints(30, 3, 4.0, rng);
        for (int i = 0; i < 30; ++i)
          points(i, 2) = 0.3 * points(i, 0) - 0.7 * points(i, 1) + noise * rng.Normal() + distance;
        const Eigen::RowVector3d centroid = points.colwise().mean();
        const Eigen::MatrixXd centred = points.rowwise() - centroid;
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(centred, Eigen::ComputeThinV);
        const Eigen::Vector3d normal = svd.matrixV().col(2);
        Plane::Parameters plane;
        REQUIRE(Plane::Fit(points, Eigen::VectorXd::Ones(30), &plane));
        CHECK(plane.head<3>().cross(normal).norm() < 1e-9);
        CHECK(Plane::Residual(plane, centroid.data()) < 1e-9);
      }
    }
  }
}

TEST_CASE("Symmetric and collinear points have no unique fit") {
  PointMatrix square(4, 2);
  square << 0, 0, 1, 0, 1, 1, 0, 1;
  Line::Parameters line;
  CHECK_FALSE(Line::Fit(square, Eigen::VectorXd::Ones(4), &line));
  PointMatrix collinear(5, 3);
  for (int i = 0; i < 5; ++i) collinear.row(i) = Eigen::RowVector3d(1, 2, 3) + i * Eigen::RowVector3d(0.3, -1, 2);
  Plane::Parameters plane;
  CHECK_FALSE(Plane::Fit(collinear, Eigen::VectorXd::Ones(5), &plane));
  CHECK_FALSE(Plane::Determined(collinear));
  collinear(4, 0) += 0.1;
  CHECK(Plane::Fit(collinear, Eigen::VectorXd::Ones(5), &plane));
  CHECK(Plane::Determined(collinear));
}

TEMPLATE_TEST_CASE_SIG("Residuals over columns equal those of each point bit for bit", "", ((int D), D), 2, 3) {
  Rng rng(6);
  const PointMatrix points = RandomPoints(37, D, 10.0, rng);
  const Eigen::MatrixXd columns = points;
  const double* pointers[D];
  for (int i = 0; i < D; ++i) pointers[i] = columns.col(i).data();
  Parameters<D> model;
  for (double& value : model) value = rng.Normal();
  std::vector<double> residuals(30);
  Hyperplane<D>::Residuals(model, pointers, 5, 35, residuals.data());
  for (int i = 0; i < 30; ++i) CHECK(residuals[i] == Hyperplane<D>::Residual(model, points.data() + (i + 5) * D));
}

TEST_CASE("Angles between models") {
  const Eigen::Vector3d x(1, 0, 5), minus_x(-1, 0, 2), diagonal(std::sqrt(0.5), std::sqrt(0.5), 0), y(0, 2, 0);
  CHECK(AngleBetweenDegrees(x, minus_x) == 0.0);
  CHECK(AngleBetweenDegrees(x, diagonal) == Approx(45.0));
  CHECK(AngleBetweenDegrees(x, y) == Approx(90.0));
  const double tiny = 1e-9;
  CHECK(AngleBetweenDegrees(x, Eigen::Vector3d(std::cos(tiny), std::sin(tiny), 0)) ==
        Approx(tiny * 180.0 / 3.14159265358979).epsilon(1e-6));
  CHECK(std::isnan(AngleBetweenDegrees(x, ModelParameters())));
  CHECK(std::isnan(AngleBetweenDegrees(x, Eigen::Vector3d::Zero())));
}

}  // namespace
}  // namespace diffsac
