#include "lab/report/pair_images.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <utility>

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

TEST_CASE("the names of a pair's images are the example's, or stand in its id") {
  using Names = std::pair<std::string, std::string>;
  Example example;
  example.id = "castle/0001-0023";
  CHECK(ImageNames(example) == Names("0001", "0023"));
  example.id = "castle";
  CHECK(ImageNames(example) == Names());
  example.image1 = "a.png";
  example.image2 = "b.png";
  CHECK(ImageNames(example) == Names("a.png", "b.png"));
}

}  // namespace diffsac
