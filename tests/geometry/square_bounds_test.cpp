#include "diffsac/geometry/square_bounds.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::RandomProblem;

/// Of points [begin, end); empty where there are no bounds.
template <class Model>
std::vector<float> BoundsOf(const PointMatrix& points, const Matrix3Parameters& model, double threshold) {
  const Eigen::MatrixXd columns = points;
  const double* pointers[4];
  for (int j = 0; j < 4; ++j) pointers[j] = columns.col(j).data();
  const int count = static_cast<int>(points.rows());
  const typename Model::Bounds bounds(pointers, count);
  typename Model::Bounds::Prepared prepared;
  if (!bounds.Prepare(model, threshold, &prepared)) return {};
  std::vector<float> squares(count);
  // In two parts: the first point of a part is not the first of all.
  const int middle = count / 3;
  bounds(prepared, 0, middle, squares.data());
  bounds(prepared, middle, count, squares.data() + middle);
  return squares;
}

/// `slack`: of a bound below the residual's square, for squares of at least .05.
template <class Model>
void CheckBounds(const PointMatrix& points, const Matrix3Parameters& model, double threshold, double slack) {
  const std::vector<float> bounds = BoundsOf<Model>(points, model, threshold);
  REQUIRE(!bounds.empty());
  int above = 0, loose = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double share = Model::Residual(model, points.data() + 4 * i) / threshold;
    above += bounds[i] > share * share || !(bounds[i] >= 0.0f) ? 1 : 0;
    loose += share * share >= 0.05 && bounds[i] < (1.0 - slack) * share * share ? 1 : 0;
  }
  CHECK(above == 0);
  CHECK(loose <= points.rows() / 10);  // Those near an epipole.
}

/// Models near and far from the truth, and degenerate ones.
std::vector<Matrix3Parameters> ModelsAround(const Matrix3Parameters& truth, Rng& rng) {
  std::vector<Matrix3Parameters> models = {truth, 1e-3 * truth, -truth};
  for (const double change : {1e-4, 1e-2, 1.0}) {
    Matrix3Parameters model = truth;
    for (double& value : model) value += change * std::abs(value) * rng.Normal();
    models.push_back(model);
  }
  Matrix3Parameters random;
  for (double& value : random) value = rng.Normal();
  models.push_back(random);
  const Eigen::Matrix3d rank_one = AsMatrix(truth).col(0) * AsMatrix(random).row(0);
  models.push_back(AsParameters(rank_one));
  return models;
}

TEST_CASE("Bounds are below the squares of F and E, and near them, at any unit and place") {
  Rng rng(1);
  for (int trial = 0; trial < 20; ++trial) {
    const auto problem = RandomProblem(150, rng, 2.0);
    for (const Matrix3Parameters& model : ModelsAround(problem.fundamental, rng)) {
      CheckBounds<Fundamental>(problem.pixels, model, 1.0, 1.0);
      CheckBounds<Fundamental>(problem.pixels, model, 1e-3, 1.0);
    }
    CheckBounds<Fundamental>(problem.pixels, problem.fundamental, 1.0, 0.05);
    CheckBounds<Essential>(problem.normalized, problem.essential, 2e-3, 0.05);
    for (const Matrix3Parameters& model : ModelsAround(problem.essential, rng))
      CheckBounds<Essential>(problem.normalized, model, 2e-3, 1.0);
    for (const double unit : {1e-8, 1e8}) {
      const Eigen::Vector3d scale(1.0 / unit, 1.0 / unit, 1.0);
      const Matrix3Parameters model =
          AsParameters(scale.asDiagonal() * AsMatrix(problem.fundamental) * scale.asDiagonal());
      CheckBounds<Fundamental>(unit * problem.pixels, model, unit, 0.05);
    }
    PointMatrix moved = problem.pixels;
    moved.array() += 1e5;
    Eigen::Matrix3d back = Eigen::Matrix3d::Identity();
    back(0, 2) = back(1, 2) = -1e5;
    CheckBounds<Fundamental>(moved, AsParameters(back.transpose() * AsMatrix(problem.fundamental) * back), 1.0, 1.0);
  }
}

TEST_CASE("Bounds are below the squares at an epipole within the image") {
  Rng rng(2);
  for (int trial = 0; trial < 20; ++trial) {
    auto problem = RandomProblem(200, rng);
    // A camera that only went ahead: [e]ₓ, with points all around the epipole.
    Eigen::Matrix3d f;
    f << 0.0, -1.0, 300.0, 1.0, 0.0, -400.0, -300.0, 400.0, 0.0;
    for (int i = 0; i < 200; ++i) {
      const double radius = std::pow(10.0, rng.Uniform(-6.0, 2.5));
      const double x = radius * rng.Normal(), y = radius * rng.Normal(), further = rng.Uniform(1.0, 1.5);
      problem.pixels.row(i) << 400.0 + x, 300.0 + y, 400.0 + further * x + rng.Normal(),
          300.0 + further * y + rng.Normal();
    }
    CheckBounds<Fundamental>(problem.pixels, AsParameters(f), 1.0, 1.0);
  }
}

TEST_CASE("Bounds are below the squares of H, and near them") {
  Rng rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix3Parameters truth = testing::RandomHomography(rng);
    PointMatrix points = testing::HomographyPoints(truth, 150, rng, 1.0);
    // Less near: what rounds is of the size of the coordinates, beside a third coordinate that may be small.
    CheckBounds<Homography>(points, truth, 1.0, 0.07);
    for (int i = 0; i < 75; ++i)
      for (int j = 0; j < 4; ++j) points(i, j) = rng.Uniform(-1000.0, 1000.0);
    for (const Matrix3Parameters& model : ModelsAround(truth, rng)) {
      const std::vector<float> bounds = BoundsOf<Homography>(points, model, 1.0);
      for (std::size_t i = 0; i < bounds.size(); ++i) {
        const double residual = Homography::Residual(model, points.data() + 4 * i);
        // One that is not finite is no inlier, whatever the bound is.
        if (std::isfinite(residual)) CHECK(bounds[i] <= residual * residual);
      }
    }
  }
}

TEST_CASE("There are no bounds where they could not hold") {
  Rng rng(4);
  const auto problem = RandomProblem(20, rng);
  const auto none = [&](const PointMatrix& points, const Matrix3Parameters& model, double threshold) {
    return BoundsOf<Fundamental>(points, model, threshold).empty();
  };
  CHECK_FALSE(none(problem.pixels, problem.fundamental, 1.0));
  CHECK(none(problem.pixels, problem.fundamental, 1e-30));
  CHECK(none(problem.pixels, problem.fundamental, std::numeric_limits<double>::quiet_NaN()));
  CHECK(none(problem.pixels, Matrix3Parameters::Zero(), 1.0));
  CHECK(none(PointMatrix::Ones(20, 4), problem.fundamental, 1.0));
  PointMatrix far = problem.pixels;
  far.array() += 1e9;
  CHECK(none(far, problem.fundamental, 1.0));
  PointMatrix spoilt = problem.pixels;
  spoilt(3, 1) = std::numeric_limits<double>::infinity();
  CHECK(none(spoilt, problem.fundamental, 1.0));
}

TEST_CASE("The bound of MSAC is its sum, and a little more") {
  Rng rng(5);
  for (const int count : {0, 1, 7, 8, 100, kBoundBlock}) {
    std::vector<float> squares(count), weights(count);
    double sum = 0.0, weighted = 0.0;
    for (int i = 0; i < count; ++i) {
      squares[i] = static_cast<float>(rng.Uniform(0.0, 2.0));
      weights[i] = static_cast<float>(rng.Uniform());
      const double term = std::max(0.0, 1.0 - static_cast<double>(squares[i]));
      sum += term;
      weighted += weights[i] * term;
    }
    for (const bool with : {false, true}) {
      const double exact = with ? weighted : sum;
      const double bound = MsacBound(squares.data(), with ? weights.data() : nullptr, count);
      CHECK(bound >= exact);
      CHECK(bound <= exact + 1e-5 * count);
    }
  }
}

}  // namespace
}  // namespace diffsac
