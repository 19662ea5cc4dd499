#include "diffsac/core/registry.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

namespace diffsac {
namespace {

struct Shape {
  static constexpr const char* kKind = "shape";
  int corners = 0;
};

const Registered<Shape> kSquare("square", {4});
const Registered<Shape> kTriangle("triangle", {3});

}  // namespace

TEST_CASE("What is registered is found by its name") {
  const auto& shapes = Registry<Shape>::Instance();
  CHECK(shapes.Names() == std::vector<std::string>{"square", "triangle"});
  CHECK(shapes.NamesText() == "square, triangle");
  CHECK(shapes.Has("square"));
  CHECK_FALSE(shapes.Has("circle"));
  CHECK(shapes.Find("triangle", "").corners == 3);
}

TEST_CASE("An unknown name is an error that names the nearest, a double one a mistake of ours") {
  auto& shapes = Registry<Shape>::Instance();
  CHECK_THROWS_WITH(shapes.Find("sqare", "f.yaml:3: type"),
                    "f.yaml:3: type: unknown shape 'sqare'; did you mean 'square'?");
  CHECK_THROWS_AS(shapes.Find("x", ""), Error);
  CHECK_THROWS_AS(shapes.Add("square", {5}), std::logic_error);
}

}  // namespace diffsac
