#include "diffsac/geometry/plane_and_parallax.h"

#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "geometry/planar_scene.h"

namespace diffsac {
namespace {

using testing::FundamentalDistance;
using testing::HomographyDistance;
using testing::MakePlanarScene;
using testing::ModelDistance;
using testing::PlanarScene;

/// Rows of a kind (1: on the plane, 2: off it, 0: outlier), in order.
std::vector<int> RowsOf(const PlanarScene& scene, int kind) {
  std::vector<int> rows;
  for (int i = 0; i < static_cast<int>(scene.kind.size()); ++i)
    if (scene.kind[i] == kind) rows.push_back(i);
  return rows;
}

/// `on` points of the plane and `off` others, mixed.
std::vector<int> MixedSet(const PlanarScene& scene, int on, int off, Rng& rng) {
  std::vector<int> set;
  const std::vector<int> plane = RowsOf(scene, 1), other = RowsOf(scene, 2);
  for (int i = 0; i < on; ++i) set.push_back(plane[i]);
  for (int i = 0; i < off; ++i) set.push_back(other[i]);
  std::vector<int> mixed(set.size());
  const std::vector<int> order = rng.Permutation(static_cast<int>(set.size()));
  for (std::size_t i = 0; i < set.size(); ++i) mixed[i] = set[order[i]];
  return mixed;
}

Eigen::Matrix<double, 8, 4, Eigen::RowMajor> Rows(const PointMatrix& points, const std::vector<int>& set) {
  Eigen::Matrix<double, 8, 4, Eigen::RowMajor> rows = Eigen::Matrix<double, 8, 4, Eigen::RowMajor>::Zero();
  for (std::size_t i = 0; i < set.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = points.row(set[i]);
  return rows;
}

using Quadruple = const double (*)[4];

TEST_CASE("The homography of three points' plane follows from F") {
  Rng rng(1);
  for (int trial = 0; trial < 200; ++trial) {
    const PlanarScene scene = MakePlanarScene(10, 0.5, 0.0, 0.0, rng);
    const auto rows = Rows(scene.views.normalized, MixedSet(scene, 5, 0, rng));
    constexpr int kTriplet[3] = {0, 1, 2};
    Eigen::Matrix3d h;
    if (!PlaneHomography(AsMatrix(scene.views.essential), reinterpret_cast<Quadruple>(rows.data()), kTriplet, &h))
      continue;
    const Matrix3Parameters model = AsParameters(h);
    for (int i = 0; i < 5; ++i) CHECK(TransferError(model, rows.data() + 4 * i) < 1e-6);
  }
}

TEST_CASE("Collinear and repeated triplets give no plane") {
  Rng rng(2);
  const PlanarScene scene = MakePlanarScene(10, 0.5, 0.0, 0.0, rng);
  auto rows = Rows(scene.views.normalized, MixedSet(scene, 3, 0, rng));
  constexpr int kTriplet[3] = {0, 1, 2};
  const Eigen::Matrix3d e = AsMatrix(scene.views.essential);
  Eigen::Matrix3d h;
  REQUIRE(PlaneHomography(e, reinterpret_cast<Quadruple>(rows.data()), kTriplet, &h));
  const auto original = rows;
  rows.row(2) = rows.row(0);
  CHECK_FALSE(PlaneHomography(e, reinterpret_cast<Quadruple>(rows.data()), kTriplet, &h));
  rows = original;
  rows.row(2) = 0.5 * (rows.row(0) + rows.row(1));
  CHECK_FALSE(PlaneHomography(e, reinterpret_cast<Quadruple>(rows.data()), kTriplet, &h));
  rows = original;
  rows(1, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(PlaneHomography(e, reinterpret_cast<Quadruple>(rows.data()), kTriplet, &h));
  CHECK_FALSE(PlaneHomography(Eigen::Matrix3d::Zero(), reinterpret_cast<Quadruple>(original.data()), kTriplet, &h));
}

TEST_CASE("Five of seven and six of eight points on a plane are found, wherever they stand, four and five are not") {
  Rng rng(3);
  int checked = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const PlanarScene scene = MakePlanarScene(20, 0.5, 0.0, 0.0, rng);
    for (const int size : {7, 8}) {
      for (int off = 0; off <= 4; ++off) {
        const auto rows = Rows(scene.views.normalized, MixedSet(scene, size - off, off, rng));
        Eigen::Matrix3d h;
        const bool found =
            FindPlaneInSet(AsMatrix(scene.views.essential), reinterpret_cast<Quadruple>(rows.data()), size, 1e-6, &h);
        CAPTURE(trial, size, off);
        CHECK(found == (off <= 2));
        checked += found ? 1 : 0;
      }
    }
  }
  CHECK(checked > 0);
}

TEST_CASE("A plane and two points off it are the epipolar geometry") {
  Rng rng(4);
  int rejected = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const PlanarScene scene = MakePlanarScene(8, 0.5, 0.0, 0.0, rng);
    const std::vector<int> off = RowsOf(scene, 2);
    const PointMatrix& points = scene.views.normalized;
    // In normalised coordinates: K2⁻¹ H K1, signed with w > 0 on the plane.
    Eigen::Matrix3d h = scene.views.k2.inverse() * AsMatrix(scene.homography) * scene.views.k1;
    const double* on = points.data() + 4 * RowsOf(scene, 1)[0];
    if (h.row(2).dot(Eigen::Vector3d(on[0], on[1], 1.0)) < 0.0) h = -h;
    Eigen::Matrix3d f;
    if (!FundamentalFromPlaneAndParallax(h, points.data() + 4 * off[0], points.data() + 4 * off[1], &f)) {
      ++rejected;
      continue;
    }
    CHECK(ModelDistance(AsParameters(f), scene.views.essential) < 1e-5);
    CHECK_FALSE(FundamentalFromPlaneAndParallax(h, points.data() + 4 * off[0], points.data() + 4 * off[0], &f));
  }
  // Points behind the plane's horizon are rightly turned the other way.
  CHECK(rejected < 50);
}

struct Recovery {
  int count = 0, fits = 0;
  Matrix3Parameters models[Fundamental::kMaxSolutions];
};

Recovery Recover(const PlanarScene& scene, const std::vector<int>& set, const Matrix3Parameters& model,
                 double threshold, std::uint64_t seed) {
  Recovery result;
  result.count = Fundamental::RecoverFromDegeneracy(scene.views.pixels, set.data(), model, threshold, Rng(seed),
                                                    result.models, &result.fits);
  return result;
}

TEST_CASE("An F whose set lies on the plane is mended to the true F") {
  Rng rng(5);
  int degenerate = 0, mended = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const PlanarScene scene = MakePlanarScene(200, 0.9, 0.2, 0.1, rng);
    const std::vector<int> plane = RowsOf(scene, 1);
    std::vector<int> set(plane.begin(), plane.begin() + 7);
    Matrix3Parameters models[3];
    const int found = SolveSevenPoints(scene.views.pixels, set.data(), models);
    for (int i = 0; i < found; ++i) {
      const Recovery result = Recover(scene, set, models[i], 1.0, trial);
      ++degenerate;
      if (result.count == 0) continue;
      CHECK(result.fits > 0);
      CHECK(result.models[0].allFinite());
      mended += FundamentalDistance(result.models[0], scene.views.fundamental) < 0.05 ? 1 : 0;
      // Depends on its arguments alone.
      const Recovery again = Recover(scene, set, models[i], 1.0, trial);
      CHECK(again.count == result.count);
      CHECK(again.fits == result.fits);
      CHECK(again.models[0] == result.models[0]);
    }
  }
  CHECK(degenerate >= 60);
  CHECK(mended >= 0.95 * degenerate);
}

TEST_CASE(
    "A set off the plane is mended where its F is supported by the plane alone, nothing is where there is no plane") {
  Rng rng(8);
  int left = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const PlanarScene planar = MakePlanarScene(200, 0.9, 0.0, 0.1, rng);
    CHECK(Recover(planar, MixedSet(planar, 3, 4, rng), planar.views.fundamental, 1.0, trial).count >= 1);
    const PlanarScene scene = MakePlanarScene(200, 0.0, 0.2, 0.1, rng);
    const std::vector<int> set = MixedSet(scene, 0, 7, rng);
    left += Recover(scene, set, scene.views.fundamental, 1.0, trial).count == 0 ? 1 : 0;
  }
  // By chance seven points can lie near a plane.
  CHECK(left >= 55);
}

TEST_CASE("Recovery survives hostile input") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  Rng rng(7);
  PlanarScene scene = MakePlanarScene(50, 0.9, 0.2, 0.3, rng);
  const std::vector<int> plane = RowsOf(scene, 1), set(plane.begin(), plane.begin() + 7);
  const Matrix3Parameters f = scene.views.fundamental;
  const PointMatrix points = scene.views.pixels;
  REQUIRE(Recover(scene, set, f, 2.0, 0).count >= 1);
  for (const double threshold : {0.0, -1.0, kNan, kInf, 1e-300, 1e300}) {
    const Recovery result = Recover(scene, set, f, threshold, 0);
    for (int i = 0; i < result.count; ++i) CHECK(result.models[i].allFinite());
  }
  CHECK(Recover(scene, set, Matrix3Parameters::Zero(), 2.0, 0).count == 0);
  CHECK(Recover(scene, set, Matrix3Parameters::Constant(kNan), 2.0, 0).count == 0);
  CHECK(Recover(scene, std::vector<int>(7, 3), f, 2.0, 0).count == 0);
  for (const double scale : {1e-8, 1e8, 1e-150, 1e150}) {
    scene.views.pixels = scale * points;
    const Eigen::DiagonalMatrix<double, 3> unit(1.0, 1.0, scale);
    const Recovery result = Recover(scene, set, AsParameters(unit * AsMatrix(f) * unit), 2.0 * scale, 0);
    for (int i = 0; i < result.count; ++i) CHECK(result.models[i].allFinite());
    if (scale == 1e-8 || scale == 1e8) CHECK(result.count >= 1);
  }
  scene.views.pixels = points;
  scene.views.pixels.bottomRows(20).setConstant(kNan);
  for (int i = 0; i < 7; ++i) scene.views.pixels.row(set[i]) = points.row(set[i]);
  const Recovery spoilt = Recover(scene, set, f, 2.0, 0);
  for (int i = 0; i < spoilt.count; ++i) CHECK(spoilt.models[i].allFinite());
}

}  // namespace
}  // namespace diffsac
