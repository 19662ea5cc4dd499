#include "lab/eval/interval_table.h"

#include <catch2/catch.hpp>

#include <cmath>

namespace diffsac {
namespace {

TEST_CASE("an interval's text says what kind of number it is") {
  const ConfidenceInterval interval{0.2083, 0.154, 0.2652};
  CHECK(IntervalText(interval, IntervalKind::kValue) == "0.208 [0.154, 0.265]");
  CHECK(IntervalText(interval, IntervalKind::kDifference) == "+0.208 [+0.154, +0.265]");
  CHECK(IntervalText(interval, IntervalKind::kMilliseconds) == "0.208 ms [0.154, 0.265]");
  CHECK(IntervalText({12.0, 9.5, 15.25}, IntervalKind::kRatio) == "×12 [9.5, 15.2]");
  CHECK(IntervalText({-0.5, std::nan(""), std::nan("")}, IntervalKind::kDifference) == "-0.500");
  CHECK(IntervalText({std::nan(""), 0.0, 0.0}, IntervalKind::kValue) == kUnknown);
}

TEST_CASE("a difference is certain where 0 is outside, a ratio where 1 is, a value never") {
  CHECK(IsCertain({0.2, 0.1, 0.3}, IntervalKind::kDifference));
  CHECK(IsCertain({-0.2, -0.3, -0.1}, IntervalKind::kDifference));
  CHECK_FALSE(IsCertain({0.2, 0.0, 0.3}, IntervalKind::kDifference));
  CHECK_FALSE(IsCertain({1.2, 0.9, 1.3}, IntervalKind::kRatio));
  CHECK(IsCertain({0.5, 0.4, 0.9}, IntervalKind::kRatio));
  CHECK_FALSE(IsCertain({0.5, 0.4, 0.9}, IntervalKind::kValue));
  CHECK_FALSE(IsCertain({0.5, std::nan(""), std::nan("")}, IntervalKind::kDifference));
}

TEST_CASE("a row of intervals has unknown ones and bold ones") {
  Table table;
  AddIntervalRow("a − b", {ConfidenceInterval{0.2, 0.1, 0.3}, std::nullopt, ConfidenceInterval{0.2, -0.1, 0.3}},
                 IntervalKind::kDifference, &table);
  REQUIRE(table.rows.size() == 1);
  CHECK(table.rows[0].cells ==
        std::vector<std::string>{"a − b", "+0.200 [+0.100, +0.300]", kUnknown, "+0.200 [-0.100, +0.300]"});
  CHECK(table.rows[0].best == std::vector<bool>{false, true, false, false});
}

}  // namespace
}  // namespace diffsac
