#include "diffsac/problem/keypoint_similarity.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace diffsac {

TEST_CASE("a similarity is what is between two keypoints, its turn within (−π, π]") {
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

}  // namespace diffsac
