#include "diffsac/report/svg_chart.h"

#include <catch2/catch.hpp>
#include <limits>

#include "diffsac/report/svg_axes.h"

namespace diffsac {
namespace {

using Catch::Contains;

// A tick of 0.3 is 3 · 0.1.
void CheckTicks(const SvgAxis& axis, int count, const std::vector<double>& expected) {
  const std::vector<double> ticks = axis.Ticks(count);
  REQUIRE(ticks.size() == expected.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) CHECK(ticks[i] == Approx(expected[i]).margin(1e-12));
}

TEST_CASE("ticks are round numbers within the axis, about as many as asked") {
  CheckTicks({0.0, 1.0, 0.0, 100.0, false}, 5, {0.0, 0.2, 0.4, 0.6, 0.8, 1.0});
  CheckTicks({0.05, 0.95, 0.0, 100.0, false}, 10, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9});
  CheckTicks({-30.0, 120.0, 0.0, 100.0, false}, 4, {0.0, 50.0, 100.0});
  // Logarithmic: twos and fives between few powers of ten.
  CheckTicks({1.0, 100.0, 0.0, 100.0, true}, 5, {1, 2, 5, 10, 20, 50, 100});
  CheckTicks({3.0, 40.0, 0.0, 100.0, true}, 5, {5, 10, 20});
  CheckTicks({0.01, 1000.0, 0.0, 100.0, true}, 5, {0.01, 0.1, 1, 10, 100, 1000});
}

TEST_CASE("values go to pixels, in proportion or by their logarithm") {
  const SvgAxis linear{0.0, 4.0, 100.0, 20.0, false}, logarithmic{1.0, 100.0, 0.0, 60.0, true};
  CHECK(linear.At(0.0) == 100.0);
  CHECK(linear.At(1.0) == 80.0);
  CHECK(logarithmic.At(10.0) == Approx(30.0));
}

TEST_CASE("a point with an interval has its whiskers, one without has none") {
  LineChart chart;
  Curve curve;
  curve.label = "a";
  CurvePoint point;
  point.x = 1.0;
  point.y = 0.5;
  point.low = point.high = std::numeric_limits<double>::quiet_NaN();
  curve.points = {point};
  point.x = 2.0;
  curve.points.push_back(point);
  chart.curves = {curve};
  const std::string whisker = "stroke-width:1;opacity:.6";
  CHECK_THAT(SvgOf(chart), !Contains(whisker));
  chart.curves[0].points[0].low = 0.4;
  chart.curves[0].points[0].high = 0.6;
  CHECK_THAT(SvgOf(chart), Contains(whisker));
}

}  // namespace
}  // namespace diffsac
