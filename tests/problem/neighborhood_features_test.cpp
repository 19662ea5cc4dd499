#include "diffsac/problem/neighborhood_features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/nearest_eight.h"

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

auto FeaturesOf(const PointMatrix& points, const Eigen::VectorXd& ratios) {
  return NeighborhoodFeatures(points, FindGoodNeighbors(points, ratios));
}

float Difference(const Scene& a, const PointMatrix& points) {
  return (FeaturesOf(a.points, a.ratios) - FeaturesOf(points, a.ratios)).cwiseAbs().maxCoeff();
}

// What the header says of one match, by comparing everything with everything.
Eigen::RowVector3d Expected(const PointMatrix& points, const std::vector<int>& good, int match) {
  std::array<std::vector<int>, 2> nearest;
  double stretch = 0.0, incoherence = 0.0;
  const auto median = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return 0.5 * (values[3] + values[4]);
  };
  for (int image = 0; image < 2; ++image) {
    const auto step = [&](int other, int in) -> Eigen::RowVector2d {
      return points.row(other).segment<2>(2 * in) - points.row(match).segment<2>(2 * in);
    };
    nearest[image] = good;
    std::erase(nearest[image], match);
    std::stable_sort(nearest[image].begin(), nearest[image].end(),
                     [&](int a, int b) { return step(a, image).squaredNorm() < step(b, image).squaredNorm(); });
    nearest[image].resize(8);
    std::vector<double> stretches, incoherences;
    for (int other : nearest[image]) {
      const double here = step(other, image).norm(), there = step(other, 1 - image).norm();
      stretches.push_back(std::log((there + 1e-4) / (here + 1e-4)));
      incoherences.push_back((step(other, 1 - image) - step(other, image)).norm() / (here + 0.02));
    }
    stretch += 0.5 * median(stretches);
    incoherence += 0.5 * median(incoherences);
  }
  const auto shared = std::count_if(nearest[0].begin(), nearest[0].end(), [&](int i) {
    return std::find(nearest[1].begin(), nearest[1].end(), i) != nearest[1].end();
  });
  return {static_cast<double>(shared) / 8.0, 0.5 * std::clamp(stretch, -4.0, 4.0),
          (2.0 + std::log(std::min(incoherence, 100.0) + 1e-3)) / 3.0};
}

void CheckExpected(const PointMatrix& points, const Eigen::VectorXd& ratios) {
  const auto count = static_cast<int>(points.rows());
  std::vector<int> good(count);
  std::iota(good.begin(), good.end(), 0);
  if (ratios.size() == count) {
    const auto rank = [&](int i) { return std::isnan(ratios[i]) ? 1e300 : ratios[i]; };
    std::stable_sort(good.begin(), good.end(), [&](int a, int b) { return rank(a) < rank(b); });
    good.resize(std::min(count, std::max(16, count / 4)));
    std::sort(good.begin(), good.end());
  }
  const auto values = FeaturesOf(points, ratios);
  double most = 0.0;
  for (int i = 0; i < count; ++i)
    most = std::max(most, (values.row(i).cast<double>() - Expected(points, good, i)).cwiseAbs().maxCoeff());
  CHECK(most < 1e-5);
}

}  // namespace

TEST_CASE("neighborhood features: what the header says, however the matches lie") {
  const Scene scene = MakeScene();
  CheckExpected(scene.points, scene.ratios);
  CheckExpected(scene.points, {});
  for (const int count : {9, 16, 17, 70}) CheckExpected(scene.points.topRows(count), scene.ratios.head(count));
  Scene changed = scene;
  for (int i = 0; i < 300; i += 3) changed.ratios[i] = std::numeric_limits<double>::quiet_NaN();
  changed.points.row(3) << 1e4, -2e3, -1e3, 5e3;                // far from all others
  for (int i = 0; i < 200; ++i) changed.points.row(i) *= 1e-4;  // nearly in one place
  CheckExpected(changed.points, changed.ratios);
  changed = scene;
  changed.points.col(1).setConstant(0.25);  // on a line in image 1
  for (int i = 0; i < 100; ++i) changed.points.row(200 + i) = changed.points.row(i);
  CheckExpected(changed.points, changed.ratios);
  // Ties: everything in one place of image 1, and on a lattice.
  changed.points.leftCols(2).setZero();
  CheckExpected(changed.points, changed.ratios);
  changed.points = (16.0 * scene.points).array().round() / 16.0;
  CheckExpected(changed.points, changed.ratios);
}

TEST_CASE("neighborhood features: correct matches move as the good ones around them") {
  const Scene scene = MakeScene();
  const auto values = FeaturesOf(scene.points, scene.ratios);
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
  const auto values = FeaturesOf(scene.points, scene.ratios);
  const auto after = FeaturesOf(permuted.points, permuted.ratios);
  for (int i = 0; i < kCorrect + kWrong; ++i)
    CHECK((after.row(i) - values.row(order[i])).cwiseAbs().maxCoeff() < 1e-6f);
}

TEST_CASE("neighborhood features: few, equal and unrated matches are finite") {
  for (const int count : {0, 1, 8, 9, 17}) {
    const auto values = FeaturesOf(PointMatrix::Zero(count, 4), {});
    CHECK(values.rows() == count);
    CHECK(values.allFinite());
  }
  Scene scene = MakeScene();
  CHECK(FeaturesOf(scene.points, {}).allFinite());
  scene.ratios.setConstant(std::numeric_limits<double>::quiet_NaN());
  CHECK(FeaturesOf(scene.points, scene.ratios).allFinite());
}

namespace {

// By comparing everything with everything.
EightNearest Expected(const PlanePoints& points, double x, double y, int own) {
  std::vector<std::pair<double, int>> ranked;
  for (int j = 0; j < static_cast<int>(points.size()); ++j) {
    const double dx = points.x[j] - x, dy = points.y[j] - y;
    if (j != own) ranked.emplace_back(dx * dx + dy * dy, j);
  }
  std::partial_sort(ranked.begin(), ranked.begin() + kEight, ranked.end());
  EightNearest nearest;
  for (int k = 0; k < kEight; ++k) nearest[k] = ranked[k].second;
  return nearest;
}

// The points themselves, and as many other places.
void CheckAll(const PlanePoints& points, const PlanePoints& others) {
  PlanePoints places = points;
  places.x.insert(places.x.end(), others.x.begin(), others.x.end());
  places.y.insert(places.y.end(), others.y.begin(), others.y.end());
  std::vector<std::int32_t> own(places.size(), -1);
  std::iota(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(points.size()), 0);
  const auto nearest = NearestEight(points, places, own);
  REQUIRE(nearest.size() == places.size());
  int wrong = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    wrong += nearest[i] == Expected(points, places.x[i], places.y[i], own[i]) ? 0 : 1;
  CHECK(wrong == 0);
}

template <class Place>
PlanePoints Make(int count, const Place& place) {
  PlanePoints points(count);
  for (int i = 0; i < count; ++i) std::tie(points.x[i], points.y[i]) = place(i);
  return points;
}

using Pair = std::pair<double, double>;

}  // namespace

TEST_CASE("nearest eight: the same as comparing all, however the points lie") {
  Rng rng(4);
  const auto anywhere = [&](int) { return Pair(rng.Uniform(-1.0, 1.0), rng.Uniform(-0.7, 0.7)); };
  const auto clusters = [&](int i) {
    return Pair(i % 3 + 1e-3 * rng.Normal(), i % 5 == 0 ? rng.Uniform(-1.0, 1.0) : 1e-5 * rng.Normal());
  };
  const auto line = [&](int) { return Pair(rng.Uniform(-3.0, 3.0), 0.25); };
  const auto outlier = [&](int i) { return i == 7 ? Pair(1e3, -1e4) : Pair(rng.Uniform(), rng.Uniform()); };
  for (const int count : {9, 10, 16, 17, 63, 64, 65, 500, 1501}) {
    CheckAll(Make(count, anywhere), Make(count, anywhere));
    CheckAll(Make(count, clusters), Make(count, anywhere));
    CheckAll(Make(count, line), Make(count, clusters));
    CheckAll(Make(count, outlier), Make(count, outlier));
  }
}

TEST_CASE("nearest eight: of equally near points the lower numbers") {
  Rng rng(5);
  const auto lattice = [&](int) {
    return Pair(static_cast<double>(rng.Below(12)) / 64.0, static_cast<double>(rng.Below(12)) / 64.0);
  };
  const auto one_place = [](int) { return Pair(0.5, -0.25); };
  const auto two_places = [](int i) { return Pair(i % 2, 0.0); };
  for (const int count : {9, 40, 700}) {
    CheckAll(Make(count, lattice), Make(count, lattice));
    CheckAll(Make(count, one_place), Make(count, lattice));
    CheckAll(Make(count, two_places), Make(count, one_place));
  }
}

TEST_CASE("nearest eight: huge, tiny and not finite coordinates") {
  Rng rng(6);
  for (const double unit : {1e-300, 1e-20, 1e20, 1e300}) {
    const auto anywhere = [&](int) { return Pair(rng.Uniform(), rng.Uniform()); };
    const PlanePoints points = Make(100, anywhere);
    PlanePoints scaled = points;
    for (int i = 0; i < 100; ++i) scaled.x[i] *= unit, scaled.y[i] *= unit;
    const std::vector<std::int32_t> own(100, -1);
    const auto nearest = NearestEight(points, points, own), after = NearestEight(scaled, scaled, own);
    for (int i = 0; i < 100; ++i) CHECK(nearest[i][0] == after[i][0]);
  }
  PlanePoints broken(20);
  broken.x[3] = std::numeric_limits<double>::quiet_NaN();
  broken.y[4] = std::numeric_limits<double>::infinity();
  const auto nearest = NearestEight(broken, broken, std::vector<std::int32_t>(20, -1));
  CHECK(nearest[0] == EightNearest{0, 1, 2, 3, 4, 5, 6, 7});
}

}  // namespace diffsac
