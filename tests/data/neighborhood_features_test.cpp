#include "diffsac/data/neighborhood_features.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

constexpr int kCorrect = 150, kWrong = 150;

// Correct matches move by one similarity, wrong ones anywhere; ratios tell them apart only roughly.
struct Scene {
  PointMatrix points = PointMatrix(kCorrect + kWrong, 4);
  Eigen::VectorXd ratios = Eigen::VectorXd(kCorrect + kWrong);
};

Scene MakeScene() {
  Scene scene;
  Rng rng(7);
  const Eigen::Rotation2Dd turn(0.1);
  for (int i = 0; i < kCorrect + kWrong; ++i) {
    const Eigen::Vector2d first(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.4, 0.4));
    Eigen::Vector2d second(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.4, 0.4));
    if (i < kCorrect) second = turn * (1.1 * first) + Eigen::Vector2d(0.1, 0.02);
    scene.points.row(i) << first.transpose(), second.transpose();
    scene.ratios[i] = i < kCorrect ? rng.Uniform(0.2, 0.95) : rng.Uniform(0.6, 1.0);
  }
  return scene;
}

float Difference(const Scene& a, const PointMatrix& points) {
  return (NeighborhoodFeatures(a.points, a.ratios) - NeighborhoodFeatures(points, a.ratios)).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("neighborhood features: correct matches move as the good ones around them") {
  const Scene scene = MakeScene();
  const auto values = NeighborhoodFeatures(scene.points, scene.ratios);
  REQUIRE(values.rows() == kCorrect + kWrong);
  const auto correct = values.topRows(kCorrect).colwise().mean().eval();
  const auto wrong = values.bottomRows(kWrong).colwise().mean().eval();
  CHECK(correct[0] > wrong[0] + 0.5f);
  CHECK(std::abs(correct[1]) < 0.2f);
  CHECK(correct[2] < wrong[2] - 0.5f);
}

TEST_CASE("neighborhood features: exchange, mirror and common turn change nothing") {
  const Scene scene = MakeScene();
  PointMatrix exchanged = scene.points, mirrored = scene.points, turned = scene.points;
  exchanged << scene.points.rightCols(2), scene.points.leftCols(2);
  mirrored.col(0) *= -1.0;
  mirrored.col(2) *= -1.0;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(1.3).toRotationMatrix();
  turned.leftCols(2) = scene.points.leftCols(2) * turn;
  turned.rightCols(2) = scene.points.rightCols(2) * turn;
  CHECK(Difference(scene, exchanged) < 1e-5f);
  CHECK(Difference(scene, mirrored) < 1e-5f);
  CHECK(Difference(scene, turned) < 1e-4f);
}

TEST_CASE("neighborhood features: permuted matches have permuted features") {
  const Scene scene = MakeScene();
  Scene permuted = scene;
  const auto order = Rng(3).Permutation(kCorrect + kWrong);
  for (int i = 0; i < kCorrect + kWrong; ++i) {
    permuted.points.row(i) = scene.points.row(order[i]);
    permuted.ratios[i] = scene.ratios[order[i]];
  }
  const auto values = NeighborhoodFeatures(scene.points, scene.ratios);
  const auto after = NeighborhoodFeatures(permuted.points, permuted.ratios);
  for (int i = 0; i < kCorrect + kWrong; ++i) CHECK((after.row(i) - values.row(order[i])).cwiseAbs().maxCoeff() < 1e-6f);
}

TEST_CASE("neighborhood features: few, equal and unrated matches are finite") {
  for (const int count : {0, 1, 8, 9, 17}) {
    const auto values = NeighborhoodFeatures(PointMatrix::Zero(count, 4), {});
    CHECK(values.rows() == count);
    CHECK(values.allFinite());
  }
  Scene scene = MakeScene();
  CHECK(NeighborhoodFeatures(scene.points, {}).allFinite());
  scene.ratios.setConstant(std::numeric_limits<double>::quiet_NaN());
  CHECK(NeighborhoodFeatures(scene.points, scene.ratios).allFinite());
}

}  // namespace diffsac
