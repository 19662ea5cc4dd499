#include "lab/eval/report.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <numeric>

#include "lab/eval/factor_fixtures.h"

namespace diffsac {
namespace {

using namespace testing;

std::size_t Total(const std::vector<Stratum>& strata, std::size_t condition) {
  return std::accumulate(strata.begin(), strata.end(), std::size_t{0},
                         [&](std::size_t sum, const Stratum& one) { return sum + one.problems[condition]; });
}

TEST_CASE("an edge is in the bin above it") {
  const std::vector<double> edges = {0.1, 0.25, 0.5};
  CHECK(BinOf(-1.0, edges) == 0);
  CHECK(BinOf(0.1, edges) == 1);
  CHECK(BinOf(std::nextafter(0.1, 0.0), edges) == 0);
  CHECK(BinOf(0.25, edges) == 2);
  CHECK(BinOf(0.5, edges) == 3);
  CHECK(BinOf(7.0, edges) == 3);
}

TEST_CASE("strata are named, and their counts sum to all problems") {
  const ExperimentResults results = MixedFactors();
  const std::vector<Stratum> strata = StrataOf(results, {Quantity::kInlierShare, {0.2, 0.5}, {}});
  REQUIRE(strata.size() == 3);
  CHECK(strata[0].name == "inlier_share below 0.2");
  CHECK(strata[1].name == "inlier_share 0.2-0.5");
  CHECK(strata[2].name == "inlier_share from 0.5");
  CHECK(strata[0].label == "< 0.2");
  CHECK(strata[1].label == "0.2–0.5");
  CHECK(strata[2].label == "≥ 0.5");
  CHECK(strata[0].problems == std::vector<std::size_t>{3, 3});  // 0, 1/12, 2/12
  CHECK(strata[1].problems == std::vector<std::size_t>{3, 3});  // 6/12 is above.
  CHECK(strata[2].problems == std::vector<std::size_t>{6, 6});
  CHECK(Total(strata, 0) == ProblemsOf(results, 0));
}

TEST_CASE("any quantity divides all problems that have it, whatever the bins") {
  const ExperimentResults results = MixedFactors();
  for (const std::vector<double>& bins : std::vector<std::vector<double>>{{-5.0}, {0.3}, {0.0, 1e-9, 0.9}, {1e9}}) {
    CHECK(Total(StrataOf(results, {Quantity::kInlierShare, bins, {}}), 1) == 12);
    CHECK(Total(StrataOf(results, {Quantity::kPoints, bins, {}}), 1) == 12);
    CHECK(Total(StrataOf(results, {Quantity::kBaseline, bins, {}}), 1) == 0);
  }
}

TEST_CASE("the problems of a stratum are one scene, cells stay in their places") {
  ExperimentResults results = MixedFactors();
  results.cells[1].records.resize(2);
  const std::vector<Stratum> strata = StrataOf(results, {Quantity::kPoints, {35.0}, {}});
  REQUIRE(strata.size() == 2);
  const ExperimentResults& high = strata[1].results;
  REQUIRE(high.cells.size() == results.cells.size());
  CHECK(high.cells[1].records.empty());
  CHECK(high.cells[7].method == results.cells[7].method);
  REQUIRE(high.cells[0].records.size() == 8);
  CHECK(high.cells[0].records[0].id == "p4");
  CHECK(SceneValuesOf(high.cells[0], [](const ProblemRecord&) { return 1.0; }).size() == 1);
  CHECK(strata[1].problems[0] == 8);
}

TEST_CASE("a problem whose quantity is unknown is in no stratum") {
  ExperimentResults results = MixedFactors();
  for (Cell& cell : results.cells) cell.records[5].inlier_share = std::nan("");
  const std::vector<Stratum> strata = StrataOf(results, {Quantity::kInlierShare, {0.2, 0.5}, {}});
  CHECK(Total(strata, 0) == 11);
  CHECK(strata[1].problems[0] == 2);
}

TEST_CASE("scenes are strata in the order in which they appear") {
  const std::vector<Stratum> strata = StrataOf(MixedFactors(), {Quantity::kScene, {}, {}});
  REQUIRE(strata.size() == 2);
  CHECK(strata[0].name == "scene a");
  CHECK(strata[1].label == "b");
  CHECK(strata[0].problems == std::vector<std::size_t>{4, 4});
  CHECK(strata[1].problems == std::vector<std::size_t>{8, 8});
}

}  // namespace
}  // namespace diffsac
