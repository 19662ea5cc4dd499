#include "diffsac/consensus/scores/square_histogram.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

TEST_CASE("A square is in the bin whose edges it is between, four an octave") {
  Rng rng(1);
  for (int i = 0; i < 10000; ++i) {
    const double square = std::exp(-20.0 * rng.Uniform());
    const int bin = SquareHistogram::BinOf(square);
    REQUIRE(bin >= 0);
    REQUIRE(bin < SquareHistogram::kBins);
    REQUIRE(SquareHistogram::Least(bin) <= square);
    if (bin + 1 < SquareHistogram::kBins) REQUIRE(square < SquareHistogram::Least(bin + 1));
  }
  constexpr int kLast = SquareHistogram::kBins - 1;
  CHECK(SquareHistogram::BinOf(std::nextafter(1.0, 0.0)) == kLast);
  CHECK(SquareHistogram::Least(kLast) == 0.875);
  CHECK(SquareHistogram::Least(kLast - 3) == 0.5);
  CHECK(SquareHistogram::Least(0) == 0.0);
  for (const double least : {0.0, -0.0, -1e-9, 1e-300}) CHECK(SquareHistogram::BinOf(least) == 0);
}

TEST_CASE("Weights and squares add up, and what is far or no number counts in the total alone") {
  SquareHistogram histogram;
  const std::vector<double> squares = {0.6, 0.55, 1.0, 2.0, std::numeric_limits<double>::quiet_NaN(), 1e-20};
  const std::vector<double> weights = {1.0, 0.5, 0.25, 1.0, 1.0, 0.125};
  histogram.Add(squares.data(), weights.data(), 6);
  const SquareHistogram::Bin& bin = histogram[SquareHistogram::BinOf(0.6)];
  CHECK(bin.weight == 1.5);
  CHECK(bin.squares == Approx(0.6 + 0.5 * 0.55));
  CHECK(histogram[0].weight == 0.125);
  CHECK(histogram.total() == 3.875);
  double sum = 0.0;
  for (int b = 0; b < SquareHistogram::kBins; ++b) sum += histogram[b].weight;
  CHECK(sum == 1.625);
}

}  // namespace
}  // namespace diffsac
