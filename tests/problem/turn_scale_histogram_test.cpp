#include "diffsac/problem/turn_scale_histogram.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace diffsac {

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
