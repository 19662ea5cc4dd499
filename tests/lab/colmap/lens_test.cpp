#include "lab/colmap/lens.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/errors.h"

namespace diffsac {
namespace {

using Eigen::Vector2d;

// Each of COLMAP's models with a lens of ordinary strength.
const std::vector<ColmapCamera>& Cameras() {
  static const std::vector<ColmapCamera> cameras = {
      {0, {640, 480}, {500, 320, 240}},
      {1, {640, 480}, {500, 510, 321, 239}},
      {2, {640, 480}, {500, 320, 240, -0.15}},
      {3, {640, 480}, {500, 320, 240, -0.15, 0.05}},
      {4, {640, 480}, {500, 510, 320, 240, -0.2, 0.06, 0.003, -0.002}},
      {5, {640, 480}, {300, 310, 320, 240, 0.05, -0.01, 0.002, 0.001}},
      {6, {640, 480}, {500, 510, 320, 240, 0.1, 0.02, 0.001, -0.002, 0.01, 0.2, 0.03, 0.01}},
      {7, {640, 480}, {400, 410, 320, 240, 0.9}},
      {8, {640, 480}, {300, 320, 240, 0.03}},
      {9, {640, 480}, {300, 320, 240, 0.03, -0.01}},
      {10, {640, 480}, {300, 310, 320, 240, 0.03, -0.01, 0.001, 0.002, 0.001, 0.0005, 0.002, -0.001}}};
  return cameras;
}

}  // namespace

TEST_CASE("lens: every model of COLMAP's, there and back over the whole image") {
  for (const ColmapCamera& camera : Cameras()) {
    INFO(*ColmapModelName(camera.model));
    const ColmapLens lens(camera, "here");
    double moved = 0.0;
    for (double x : {0.0, 33.0, 320.0, 639.0})
      for (double y : {0.0, 239.5, 400.0, 479.0}) {
        const std::optional<Vector2d> straight = lens.Undistort({x, y});
        REQUIRE(straight);
        CHECK((lens.Distort(*straight) - Vector2d(x, y)).norm() < 1e-6);
        moved = std::max(moved, (*straight - Vector2d(x, y)).norm());
      }
    if (camera.model < 2)
      CHECK(moved == 0.0);
    else
      CHECK(moved > 3.0);
  }
}

TEST_CASE("lens: COLMAP's first pixel has its centre at a half") {
  const ColmapLens lens(Cameras()[1], "here");
  CHECK(lens.K() == (Eigen::Matrix3d() << 500, 0, 320.5, 0, 510, 238.5, 0, 0, 1).finished());
}

TEST_CASE("lens: values worked out by hand") {
  // r² = .25: 1 + .25 k along the point.
  const ColmapLens radial({2, {640, 480}, {100, 0.5, 0.5, 0.4}}, "here");
  CHECK((radial.Distort({30, 40}) - Vector2d(33, 44)).norm() < 1e-9);
  // Tangential: x + 2 p1 xy + p2 (r² + 2x²), y + 2 p2 xy + p1 (r² + 2y²).
  const ColmapLens tangential({4, {640, 480}, {100, 100, 0.5, 0.5, 0, 0, 0.01, 0.02}}, "here");
  CHECK((tangential.Distort({30, 40}) - Vector2d(30 + 0.24 + 0.86, 40 + 0.48 + 0.57)).norm() < 1e-9);
  // An equidistant fisheye shows 45° at f π / 4.
  const ColmapLens fisheye({5, {640, 480}, {100, 100, 0.5, 0.5, 0, 0, 0, 0}}, "here");
  CHECK((fisheye.Distort({100, 0}) - Vector2d(100 * std::atan(1.0), 0)).norm() < 1e-9);
  const ColmapLens fov({7, {640, 480}, {100, 100, 0.5, 0.5, 1.0}}, "here");
  CHECK((fov.Distort({0, 100}) - Vector2d(0, 100 * std::atan(2.0 * std::tan(0.5)))).norm() < 1e-9);
}

TEST_CASE("lens: rays that no pinhole camera sees") {
  const ColmapLens fisheye({5, {2000, 2000}, {300, 300, 1000, 1000, 0, 0, 0, 0}}, "here");
  CHECK(fisheye.Undistort({999.5 + 300 * 1.5, 999.5}));
  CHECK_FALSE(fisheye.Undistort({999.5 + 300 * 1.6, 999.5}));
  // Barrel distortion reaches no further than where it folds over.
  const ColmapLens folded({2, {2000, 2000}, {500, 1000, 1000, -0.3}}, "here");
  CHECK_FALSE(folded.Undistort({1990, 1990}));
}

TEST_CASE("lens: cameras that are none") {
  const auto error = [](const ColmapCamera& camera) { return ErrorOf([&] { ColmapLens(camera, "a.db: camera 3"); }); };
  CHECK(Has(error({11, {640, 480}, {1}}), "a.db: camera 3: unknown camera model 11"));
  CHECK(Has(error({-1, {640, 480}, {1}}), "unknown camera model -1"));
  CHECK(Has(error({2, {640, 480}, {500, 1, 1}}), "expected 4 parameters for SIMPLE_RADIAL, found 3"));
  CHECK(Has(error({1, {640, 480}, {500, 0, 1, 1}}), "positive focal lengths"));
  CHECK(Has(error({0, {640, 480}, {500, NAN, 1}}), "finite"));
}

}  // namespace diffsac
