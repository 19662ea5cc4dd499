#include "diffsac/problem/similarity_features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/keypoint_similarity.h"
#include "diffsac/problem/turn_scale_histogram.h"

namespace diffsac {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kCorrect = 60, kWrong = 240;

// Few correct matches, which move by one similarity, up to noise; the keypoints of wrong ones differ anyhow.
struct Scene {
  PointMatrix points = PointMatrix(kCorrect + kWrong, 4), scale_rotation_changes = PointMatrix(kCorrect + kWrong, 2);
  Eigen::VectorXd ratios = Eigen::VectorXd(kCorrect + kWrong);
};

Scene MakeScene() {
  Scene scene;
  Rng rng(7);
  const Eigen::Rotation2Dd turn(3.0);
  for (int i = 0; i < kCorrect + kWrong; ++i) {
    const Eigen::Vector2d first(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.4, 0.4));
    Eigen::Vector2d second(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.4, 0.4));
    double log_scale = rng.Normal(), angle = rng.Uniform(-kPi, kPi);
    if (i < kCorrect) {
      second = turn * (1.3 * first) + Eigen::Vector2d(0.1, 0.02);
      log_scale = std::log(1.3) + 0.1 * rng.Normal();
      angle = std::remainder(3.0 + 0.1 * rng.Normal(), 2.0 * kPi);  // on both sides of π
    }
    scene.points.row(i) << first.transpose(), second.transpose();
    scene.scale_rotation_changes.row(i) << log_scale, angle;
    scene.ratios[i] = i < kCorrect ? rng.Uniform(0.5, 0.95) : rng.Uniform(0.6, 1.0);
  }
  return scene;
}

auto FeaturesOf(const Scene& scene) {
  return SimilarityFeatures(scene.points, scene.scale_rotation_changes, FindGoodNeighbors(scene.points, scene.ratios));
}

float Difference(const Scene& a, const Scene& b) { return (FeaturesOf(a) - FeaturesOf(b)).cwiseAbs().maxCoeff(); }

Scene Turned(const Scene& scene, double angle1, double angle2) {
  Scene turned = scene;
  const Eigen::Matrix2d turn1 = Eigen::Rotation2Dd(angle1).toRotationMatrix();
  const Eigen::Matrix2d turn2 = Eigen::Rotation2Dd(angle2).toRotationMatrix();
  turned.points.leftCols(2) = scene.points.leftCols(2) * turn1.transpose();
  turned.points.rightCols(2) = scene.points.rightCols(2) * turn2.transpose();
  for (double& angle : turned.scale_rotation_changes.col(1)) angle = std::remainder(angle + angle2 - angle1, 2.0 * kPi);
  return turned;
}

// e_ij of the header.
double ErrorOf(const Scene& scene, int i, int j) {
  const Eigen::Vector2d step1 = (scene.points.row(j) - scene.points.row(i)).head<2>();
  const Eigen::Vector2d step2 = (scene.points.row(j) - scene.points.row(i)).tail<2>();
  double most = 0.0;
  for (const int k : {i, j}) {
    const double scale = std::exp(scene.scale_rotation_changes(k, 0));
    const Eigen::Vector2d moved = Eigen::Rotation2Dd(scene.scale_rotation_changes(k, 1)) * (scale * step1);
    most = std::max(most, (moved - step2).norm() / std::min(step2.norm() + 0.02, scale * (step1.norm() + 0.02)));
  }
  return std::min(most, 100.0);
}

double TurnBetween(double a, double b) { return std::abs(std::remainder(b - a, 2.0 * kPi)); }

// The first four columns, by the header.
Eigen::RowVector4d Expected(const Scene& scene, const GoodNeighbors& around, int i) {
  double support = 0.0, error = 0.0, scale = 0.0, turn = 0.0;
  for (const auto& nearest : around.nearest) {
    std::vector<double> errors, scales, turns;
    for (const std::int32_t number : nearest[i]) {
      const int j = around.good[number];
      errors.push_back(ErrorOf(scene, i, j));
      support += 1.0 / (1.0 + std::pow(errors.back() / 0.3, 2));
      scales.push_back(std::abs(scene.scale_rotation_changes(j, 0) - scene.scale_rotation_changes(i, 0)));
      turns.push_back(TurnBetween(scene.scale_rotation_changes(i, 1), scene.scale_rotation_changes(j, 1)));
    }
    for (auto* values : {&errors, &scales, &turns}) std::sort(values->begin(), values->end());
    error += 0.5 * errors[3];
    scale += 0.25 * (scales[3] + scales[4]);
    turn += 0.25 * (turns[3] + turns[4]);
  }
  return {std::log1p(support) - 1.0, (2.0 + std::log(error + 1e-3)) / 3.0, std::min(scale, 2.0), turn};
}

// The density of the header, without cells.
double DensityOf(const Scene& scene, const GoodNeighbors& around, int i) {
  double sum = 0.0;
  int others = 0;
  for (const std::int32_t j : around.good) {
    if (j == i) continue;
    const double scale = scene.scale_rotation_changes(j, 0) - scene.scale_rotation_changes(i, 0);
    const double turn = TurnBetween(scene.scale_rotation_changes(i, 1), scene.scale_rotation_changes(j, 1));
    sum += std::exp(-(scale * scale + turn * turn) / (2.0 * 0.3 * 0.3));
    ++others;
  }
  return sum / others;
}

}  // namespace

TEST_CASE("similarity features: what the header says") {
  const Scene scene = MakeScene();
  const GoodNeighbors around = FindGoodNeighbors(scene.points, scene.ratios);
  const auto values = FeaturesOf(scene);
  double most = 0.0, most_density = 0.0;
  for (int i = 0; i < kCorrect + kWrong; ++i) {
    most = std::max(most, (values.row(i).head<4>().cast<double>() - Expected(scene, around, i)).cwiseAbs().maxCoeff());
    const double density = std::exp(1.2 * values(i, 4) - 2.3) - 0.01;
    most_density = std::max(most_density, std::abs(density - DensityOf(scene, around, i)));
  }
  CHECK(most < 1e-4);
  CHECK(most_density < 0.05);
  CHECK((values.col(5).array() == 1.0f).all());
}

TEST_CASE("similarity features: few correct matches among many wrong ones stand out") {
  const auto values = FeaturesOf(MakeScene());
  const auto correct = values.topRows(kCorrect).colwise().mean().eval();
  const auto wrong = values.bottomRows(kWrong).colwise().mean().eval();
  CHECK(correct[0] > wrong[0] + 0.7f);
  CHECK(correct[1] < wrong[1] - 0.3f);
  CHECK(correct[3] < wrong[3] - 0.3f);
  CHECK(correct[4] > wrong[4] + 1.0f);
}

TEST_CASE("similarity features: exchange, mirror and turns change nothing") {
  const Scene scene = MakeScene();
  Scene exchanged = scene, mirrored = scene;
  exchanged.points << scene.points.rightCols(2), scene.points.leftCols(2);
  exchanged.scale_rotation_changes *= -1.0;
  mirrored.points.col(0) *= -1.0;
  mirrored.points.col(2) *= -1.0;
  mirrored.scale_rotation_changes.col(1) *= -1.0;
  CHECK(Difference(scene, exchanged) < 1e-3f);
  CHECK(Difference(scene, mirrored) < 1e-4f);
  CHECK(Difference(scene, Turned(scene, 1.3, 1.3)) < 1e-3f);
  // By whole cells of the histogram.
  CHECK(Difference(scene, Turned(scene, 0.0, 2.0 * kPi * 11 / 64)) < 1e-3f);
  CHECK(Difference(scene, Turned(scene, 0.0, 0.05)) < 0.2f);
}

TEST_CASE("similarity features: permuted matches have permuted features") {
  const Scene scene = MakeScene();
  Scene permuted = scene;
  const auto order = Rng(3).Permutation(kCorrect + kWrong);
  for (int i = 0; i < kCorrect + kWrong; ++i) {
    permuted.points.row(i) = scene.points.row(order[i]);
    permuted.scale_rotation_changes.row(i) = scene.scale_rotation_changes.row(order[i]);
    permuted.ratios[i] = scene.ratios[order[i]];
  }
  const auto values = FeaturesOf(scene), after = FeaturesOf(permuted);
  for (int i = 0; i < kCorrect + kWrong; ++i)
    CHECK((after.row(i) - values.row(order[i])).cwiseAbs().maxCoeff() < 1e-5f);
}

TEST_CASE("similarity features: 0 without similarities and for few matches, and always finite") {
  Scene scene = MakeScene();
  scene.scale_rotation_changes.resize(0, 0);
  CHECK((FeaturesOf(scene).array() == 0.0f).all());
  for (const int count : {0, 1, 8, 9, 17}) {
    Scene few;
    few.points = PointMatrix::Zero(count, 4);
    few.scale_rotation_changes = PointMatrix::Zero(count, 2);
    few.ratios.resize(0);
    const auto values = FeaturesOf(few);
    REQUIRE(values.rows() == count);
    CHECK(values.allFinite());
    CHECK((count <= 8) == (values.array() == 0.0f).all());
  }
  scene = MakeScene();
  scene.scale_rotation_changes.col(0) *= 1e6;
  scene.points.row(3) << 1e200, -1e200, 1e10, 0.0;
  CHECK(FeaturesOf(scene).allFinite());
}

TEST_CASE("similarities are told in the units of coordinates") {
  const Scene scene = MakeScene();
  PointMatrix pixels = scene.points;
  pixels.leftCols(2) *= 500.0;
  pixels.rightCols(2) *= 800.0;
  pixels.array() += 300.0;
  const PointMatrix changed = InCoordinates(scene.scale_rotation_changes, pixels, scene.points);
  CHECK((changed.col(1) - scene.scale_rotation_changes.col(1)).norm() == 0.0);
  CHECK((changed.col(0).array() - scene.scale_rotation_changes.col(0).array() - std::log(500.0 / 800.0))
            .abs()
            .maxCoeff() < 1e-9);
  CHECK(InCoordinates({}, pixels, scene.points).size() == 0);
  // All in one place.
  CHECK(InCoordinates(scene.scale_rotation_changes, PointMatrix::Ones(300, 4), PointMatrix::Zero(300, 4)) ==
        scene.scale_rotation_changes);
}

TEST_CASE("a similarity is what is between two keypoints, its turn above −π and at most π") {
  const double pi = std::numbers::pi;
  const auto similarity = [](double size1, double angle1, double size2, double angle2) {
    return SimilarityOf({std::log(size1), angle1}, {std::log(size2), angle2});
  };
  CHECK(similarity(4.0, 0.5, 8.0, 1.25)[0] == Approx(std::log(2.0)));
  CHECK(similarity(4.0, 0.5, 8.0, 1.25)[1] == Approx(0.75));
  CHECK(similarity(8.0, 1.25, 4.0, 0.5)[0] == Approx(-std::log(2.0)));
  CHECK(similarity(8.0, 1.25, 4.0, 0.5)[1] == Approx(-0.75));
  CHECK(similarity(1.0, 0.1, 1.0, 2.0 * pi - 0.1)[1] == Approx(-0.2));
  CHECK(similarity(1.0, 2.0 * pi - 0.1, 1.0, 0.1)[1] == Approx(0.2));
  CHECK(similarity(1.0, 0.0, 1.0, pi)[1] == pi);
  CHECK(similarity(1.0, pi, 1.0, 0.0)[1] == pi);
}

TEST_CASE("a histogram of similarities weighs those near by, around the circle, and not the one itself") {
  constexpr float kPi = std::numbers::pi_v<float>;
  TurnScaleHistogram histogram;
  CHECK(histogram.MeanOfOthers(0.0f, 0.0f, false) == 0.0f);
  histogram.Add(0.5f, kPi);
  histogram.Smooth();
  CHECK(histogram.MeanOfOthers(0.5f, kPi, true) == 0.0f);
  CHECK(histogram.MeanOfOthers(0.5f, kPi, false) == Approx(1.0f));
  CHECK(histogram.MeanOfOthers(0.5f, -kPi, false) == Approx(1.0f));
  CHECK(histogram.MeanOfOthers(0.5f, 0.0f, false) == 0.0f);
  CHECK(histogram.MeanOfOthers(0.8f, kPi, false) == Approx(std::exp(-0.5)).epsilon(1e-5));
  histogram.Add(-1000.0f, 0.0f);
  histogram.Smooth();
  CHECK(histogram.MeanOfOthers(0.5f, kPi, false) == Approx(0.5f));
  // As far as the scales go.
  CHECK(histogram.MeanOfOthers(-3.0f, 0.0f, false) == Approx(0.5f));
}

}  // namespace diffsac
