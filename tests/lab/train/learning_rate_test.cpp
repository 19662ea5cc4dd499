#include "lab/train/learning_rate.h"

#include <catch2/catch.hpp>

namespace diffsac {

TEST_CASE("the learning rate warms up linearly and falls to 0 on a half cosine") {
  CHECK(LearningRate(0, 10, 110, 1.0) == Approx(0.1));
  CHECK(LearningRate(9, 10, 110, 1.0) == Approx(1.0));
  CHECK(LearningRate(10, 10, 110, 1.0) == Approx(1.0));
  CHECK(LearningRate(60, 10, 110, 1.0) == Approx(0.5));
  CHECK(LearningRate(110, 10, 110, 1.0) == Approx(0.0).margin(1e-12));
  for (int i = 11; i < 110; ++i) CHECK(LearningRate(i, 10, 110, 1.0) < LearningRate(i - 1, 10, 110, 1.0));
  CHECK(LearningRate(0, 0, 1, 2.0) == Approx(2.0));
}

}  // namespace diffsac
