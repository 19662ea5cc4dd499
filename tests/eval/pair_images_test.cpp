#include "diffsac/eval/pair_images.h"

#include <catch2/catch.hpp>
#include <limits>

namespace diffsac {

TEST_CASE("a canvas is the image's, or the box of its points") {
  PointMatrix points(4, 4);
  points << 10.5, 20.0, 300.0, 4.0,  //
      99.9, 3.0, 7.0, 150.2,         //
      -5.0, -7.0, 1.0, 2.0,          //
      std::numeric_limits<double>::quiet_NaN(), 5000.0, 5000.0, 5000.0;
  CHECK(CanvasSize({640, 480}, points, 0) == ImageSize{640, 480});
  CHECK(CanvasSize({}, points, 0) == ImageSize{100, 21});
  CHECK(CanvasSize({}, points, 2) == ImageSize{301, 151});
  CHECK(CanvasSize({}, points.topRows(0), 0) == ImageSize{1, 1});
  // A point that is far out asks for no gigabytes.
  points(0, 0) = 1e12;
  CHECK(CanvasSize({}, points, 0).width == 100001);
}

}  // namespace diffsac
