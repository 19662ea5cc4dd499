#include "diffsac/geometry/rigid.h"

#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "diffsac/geometry/rotation.h"
#include "geometry/cloud_scene.h"

namespace diffsac {
namespace {

using testing::CloudScene;
using testing::MakeCloudScene;

constexpr int kFirst[] = {0, 1, 2};

template <class Model>
double ScaleFor() {
  return Model::kHasScale ? 2.5 : 1.0;
}

}  // namespace

TEMPLATE_TEST_CASE("three matches without noise give the motion, and it is a rotation", "", Rigid, Similarity) {
  for (int i = 0; i < 50; ++i) {
    const CloudScene scene = MakeCloudScene(3, 0.0, 0.0, Rng(1).Fork("set", i), ScaleFor<TestType>());
    Rigid::Parameters model;
    REQUIRE(TestType::SolveMinimal(scene.points, kFirst, &model) == 1);
    CHECK((model - scene.truth).norm() < 1e-9);
    const Eigen::Matrix3d turn = RotationOf(model) / ScaleFor<TestType>();
    CHECK((turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9);
    CHECK(turn.determinant() > 0.0);
  }
}

TEMPLATE_TEST_CASE("sets on one line or in one place have no motion", "", Rigid, Similarity) {
  CloudScene scene = MakeCloudScene(3, 0.0, 0.0, Rng(2), ScaleFor<TestType>());
  const int once[] = {1, 1, 1}, twice[] = {0, 1, 1};
  Rigid::Parameters model;
  CHECK(TestType::SolveMinimal(scene.points, once, &model) == 0);
  CHECK(TestType::SolveMinimal(scene.points, twice, &model) == 0);
  scene.points.row(2) = 2.0 * scene.points.row(1) - scene.points.row(0);
  CHECK(TestType::SolveMinimal(scene.points, kFirst, &model) == 0);
  CHECK_FALSE(TestType::Determined(scene.points));
  scene.points(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK(TestType::SolveMinimal(scene.points, kFirst, &model) == 0);
  CHECK_FALSE(TestType::Determined(scene.points));
}

TEST_CASE("of very many matches on one line each is looked at before they are said to be") {
  PointMatrix points = PointMatrix::Zero(200'001, 6);
  points.col(0) = points.col(5) = Eigen::VectorXd::LinSpaced(points.rows(), 0.0, 10.0);
  CHECK_FALSE(Rigid::Determined(points));
  points(100'000, 1) = points(100'000, 3) = 5.0;
  CHECK(Rigid::Determined(points));
  points(100'000, 3) = 0.0;
  CHECK_FALSE(Rigid::Determined(points));
}

TEMPLATE_TEST_CASE("a mirrored cloud has no motion that fits it", "", Rigid, Similarity) {
  CloudScene scene = MakeCloudScene(40, 0.0, 0.0, Rng(3), ScaleFor<TestType>());
  scene.points.col(0) *= -1.0;
  Rigid::Parameters model;
  REQUIRE(TestType::Fit(scene.points, Eigen::VectorXd::Ones(40), &model));
  CHECK(RotationOf(model).determinant() > 0.0);
  CHECK(RowResiduals<TestType>(scene.points, model).maxCoeff() > 1.0);
}

TEMPLATE_TEST_CASE("the fit is the least squares of the weights: no step from it is better", "", Rigid, Similarity) {
  const CloudScene scene = MakeCloudScene(30, 0.0, 0.1, Rng(4), ScaleFor<TestType>());
  const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(30, 0.0, 2.0);
  Rigid::Parameters model;
  REQUIRE(TestType::Fit(scene.points, weights, &model));
  const auto cost = [&](const Rigid::Parameters& m) {
    return weights.dot(RowResiduals<TestType>(scene.points, m).cwiseAbs2());
  };
  for (int k = 0; k < TestType::kFreedom; ++k)
    for (const double step : {-1e-3, 1e-3}) {
      Eigen::Matrix<double, 7, 1> change = Eigen::Matrix<double, 7, 1>::Zero();
      change[k] = step;
      const Eigen::Matrix3d turn =
          std::exp(change[6]) * ExpRotation(change.head<3>()).toRotationMatrix() * RotationOf(model);
      CHECK(cost(PoseOf(turn, TranslationOf(model) + change.segment<3>(3))) > cost(model));
    }
  CHECK_FALSE(TestType::Fit(scene.points, Eigen::VectorXd::Zero(30), &model));
  Eigen::VectorXd two = Eigen::VectorXd::Zero(30);
  two.head(2).setOnes();
  CHECK_FALSE(TestType::Fit(scene.points, two, &model));
}

TEMPLATE_TEST_CASE("refinement finds the truth among wrong matches, from a start that is off", "", Rigid, Similarity) {
  const CloudScene scene = MakeCloudScene(200, 0.5, 0.01, Rng(5), ScaleFor<TestType>());
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(200);
  const Eigen::Matrix3d turn =
      ExpRotation(Eigen::Vector3d(0.01, -0.02, 0.01)).toRotationMatrix() * RotationOf(scene.truth);
  const Rigid::Parameters start = PoseOf(turn, TranslationOf(scene.truth) + Eigen::Vector3d(0.05, 0.0, -0.05));
  for (const LossKind kind : {LossKind::kTruncated, LossKind::kMarginalised, LossKind::kCauchy}) {
    Rigid::Parameters model = start;
    REQUIRE(TestType::Refine(scene.points, ones, {kind, 0.3, 0.02}, &model));
    CHECK((model - scene.truth).norm() < 0.02);
    CHECK(RotationOf(model).determinant() > 0.0);
    CHECK_FALSE(TestType::Refine(scene.points, Eigen::VectorXd::Zero(200), {kind, 0.3, 0.02}, &model));
  }
}

TEMPLATE_TEST_CASE("residuals over columns are those of single points, and lengths in the second cloud", "", Rigid,
                   Similarity) {
  const CloudScene scene = MakeCloudScene(37, 0.3, 0.1, Rng(6), ScaleFor<TestType>());
  const Eigen::VectorXd residuals = RowResiduals<TestType>(scene.points, scene.truth);
  for (Eigen::Index i = 0; i < 37; ++i) {
    CHECK(residuals[i] == TestType::Residual(scene.truth, scene.points.data() + 6 * i));
    const Eigen::Vector3d y = RotationOf(scene.truth) * scene.points.row(i).head<3>().transpose() +
                              TranslationOf(scene.truth) - scene.points.row(i).tail<3>().transpose();
    CHECK(residuals[i] == Approx(y.norm()));
  }
}

TEST_CASE("the scale of a similarity") {
  CHECK(ScaleOf(MakeCloudScene(3, 0.0, 0.0, Rng(7), 0.03).truth) == Approx(0.03));
}

}  // namespace diffsac
