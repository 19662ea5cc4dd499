#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>

#include "diffsac/consensus/make_source.h"
#include "diffsac/consensus/napsac_source.h"
#include "diffsac/consensus/weighted_source.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

PointMatrix RandomPoints(int count, int dimension, std::uint64_t seed) {
  Rng rng(seed);
  PointMatrix points(count, dimension);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = rng.Uniform(-1.0, 1.0);
  return points;
}

std::vector<double> RandomValues(int count, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<double> values(count);
  for (double& value : values) value = rng.Uniform();
  return values;
}

std::vector<int> DrawAll(const HypothesisSource& source, int num_points, int size, int count, std::uint64_t seed = 1) {
  std::vector<int> sets;
  source.DrawBlock(num_points, size, 0, count, Rng(seed), &sets);
  return sets;
}

struct NamedSource {
  std::string name;
  std::unique_ptr<HypothesisSource> source;
};

/// Every source over the same points.
std::vector<NamedSource> AllSources(const PointMatrix& points, int set_size, const std::vector<double>& quality,
                                    const std::vector<int>& given, const std::vector<float>& confidences) {
  std::vector<NamedSource> all;
  for (const char* name : {"uniform", "exhaustive", "prosac", "napsac", "p_napsac", "weighted"}) {
    SourceOptions options;
    options.source = name;
    options.prosac_samples = 150.0;
    options.local_draws = 3;
    all.push_back({name, MakeHypothesisSource(options, points, set_size, quality, quality)});
  }
  SourceOptions options;
  options.source = "p_napsac";
  all.push_back({"p_napsac without quality", MakeHypothesisSource(options, points, set_size)});
  all.push_back({"given", std::make_unique<GivenSource>(given)});
  for (bool unique : {false, true})
    all.push_back(
        {"confidence", std::make_unique<ConfidenceSource>(confidences, Selection::kProbabilistic, unique, 1.0)});
  return all;
}

TEST_CASE("Every source: valid sets, the same for any division into blocks, others for another seed") {
  constexpr int kPoints = 60, kDraws = 200;
  const PointMatrix points = RandomPoints(kPoints, 4, 1);
  const std::vector<double> quality = RandomValues(kPoints, 2);
  std::vector<float> confidences(20 * kPoints);
  for (float& value : confidences) value = static_cast<float>(RandomValues(1, 3 + (&value - confidences.data()))[0]);
  for (int size : {1, 2, 7}) {
    const std::vector<int> given = DrawAll(UniformSource(), kPoints, size, 200, 9);
    for (const auto& [name, source] : AllSources(points, size, quality, given, confidences)) {
      CAPTURE(name, size);
      const std::vector<int> whole = DrawAll(*source, kPoints, size, kDraws);
      REQUIRE(whole.size() % size == 0);
      int invalid = 0;
      for (std::size_t i = 0; i < whole.size(); ++i)
        invalid += whole[i] < 0 || whole[i] >= kPoints || (i % size > 0 && whole[i] <= whole[i - 1]);
      CHECK(invalid == 0);
      for (int block : {7, 128}) {
        std::vector<int> parts;
        for (int first = 0; first < kDraws; first += block) {
          const int count = std::min(block, kDraws - first);
          if (source->DrawBlock(kPoints, size, first, count, Rng(1), &parts) < count) break;
        }
        CHECK(parts == whole);
      }
      const bool random = name != "exhaustive" && name != "given";
      CHECK((DrawAll(*source, kPoints, size, kDraws, 2) != whole) == random);
      std::vector<int> none;
      CHECK(source->DrawBlock(kPoints, size, 0, 0, Rng(1), &none) == 0);
      if (name != "given") CHECK(source->DrawBlock(size - 1, size, 0, 5, Rng(1), &none) == 0);
      CHECK(none.empty());
    }
  }
}

TEST_CASE("Blocks of the exhaustive source start anywhere and end with the last set") {
  for (int size : {1, 2, 3, 4}) {
    std::vector<int> all;
    const int total = ExhaustiveSource().Draw(9, size, 0, Rng(1), &all);
    for (int first = 0; first < total; ++first) {
      std::vector<int> rest;
      CHECK(ExhaustiveSource().DrawBlock(9, size, first, 1000, Rng(1), &rest) == total - first);
      CHECK(std::equal(rest.begin(), rest.end(), all.begin() + first * size, all.end()));
    }
    std::vector<int> none;
    CHECK(ExhaustiveSource().DrawBlock(9, size, total, 10, Rng(1), &none) == 0);
    CHECK(none.empty());
  }
}

TEST_CASE("Given sets come in order, a broken last one does not") {
  const std::vector<int> sets{4, 1, 3, 2, 9};
  CHECK(DrawAll(GivenSource(sets), 5, 2, 10) == std::vector<int>{4, 1, 3, 2});
  CHECK(DrawAll(GivenSource({}), 5, 2, 10).empty());
}

TEST_CASE("Nearest neighbours agree with a search by hand, coinciding points included") {
  PointMatrix points = RandomPoints(200, 4, 3);
  for (int i = 0; i < 30; ++i) points.row(50 + i) = points.row(10);
  const NeighborIndex index(points);
  for (int i : {0, 10, 60, 199}) {
    std::vector<std::pair<double, int>> others;
    for (int j = 0; j < 200; ++j)
      if (j != i) others.emplace_back((points.row(i) - points.row(j)).squaredNorm(), j);
    std::sort(others.begin(), others.end());
    const std::vector<int> nearest = index.Nearest(i, 12);
    REQUIRE(nearest.size() == 12);
    for (int k = 0; k < 12; ++k)
      CHECK((points.row(i) - points.row(nearest[k])).squaredNorm() == Approx(others[k].first).margin(1e-15));
    CHECK(std::count(nearest.begin(), nearest.end(), i) == 0);
  }
  CHECK(index.Nearest(3, 500).size() == 199);
  // From the place of a point the same others follow the point itself.
  const std::vector<int> from = index.NearestTo(points.row(199).data(), 13), others = index.Nearest(199, 12);
  REQUIRE(from.size() == 13);
  CHECK(from.front() == 199);
  CHECK(std::vector<int>(from.begin() + 1, from.end()) == others);
  CHECK(index.Nearest(3, 0).empty());
  CHECK(NeighborIndex(RandomPoints(1, 2, 1)).Nearest(0, 3).empty());
  const auto edges = NeighborEdges(points, 5);
  CHECK(std::is_sorted(edges.begin(), edges.end()));
  CHECK(std::adjacent_find(edges.begin(), edges.end()) == edges.end());
  CHECK(std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge.first < edge.second; }));
}

TEST_CASE("NAPSAC draws sets of neighbours, each point equally often first") {
  // Five clusters far apart.
  PointMatrix points = 0.1 * RandomPoints(100, 2, 4);
  for (int i = 0; i < 100; ++i) points(i, 0) += 10.0 * (i / 20);
  const std::vector<int> sets = DrawAll(NapsacSource(points, 10), 100, 3, 2000);
  std::vector<int> clusters(5, 0);
  int mixed = 0;
  for (std::size_t i = 0; i < sets.size(); i += 3) {
    mixed += sets[i] / 20 != sets[i + 2] / 20;
    ++clusters[sets[i] / 20];
  }
  CHECK(mixed == 0);
  for (int count : clusters) CHECK(count == Approx(400).margin(80));
  // More points than neighbours: the neighbourhood is as large as it must be.
  CHECK(DrawAll(NapsacSource(points, 1), 100, 5, 10).size() == 50);
}

TEST_CASE("Progressive NAPSAC starts with the nearest points and ends with all") {
  const PointMatrix points = RandomPoints(200, 2, 5);
  const ProgressiveNapsacSource source(points, {}, 3, 20);
  const NeighborIndex index(points);
  std::vector<int> sets;
  REQUIRE(source.DrawBlock(200, 3, 0, 6000, Rng(1), &sets) == 6000);
  const auto spread = [&](int begin, int end) {
    double sum = 0.0;
    for (int i = begin; i < end; ++i)
      sum += (points.row(sets[3 * i]) - points.row(sets[3 * i + 2])).norm() / (end - begin);
    return sum;
  };
  CHECK(spread(0, 200) < 0.3 * spread(5000, 6000));
  CHECK(spread(200, 1000) < spread(3000, 4000));
  // The first set of all is a point and its two nearest.
  bool found = false;
  for (int center = 0; center < 3; ++center) {
    std::vector<int> near = index.Nearest(sets[center], 2);
    near.push_back(sets[center]);
    std::sort(near.begin(), near.end());
    found |= std::equal(near.begin(), near.end(), sets.begin());
  }
  CHECK(found);
}

TEST_CASE("Progressive NAPSAC with a quality starts at the best points") {
  const PointMatrix points = RandomPoints(300, 4, 6);
  std::vector<double> quality(300);
  std::iota(quality.begin(), quality.end(), 0.0);
  const ProgressiveNapsacSource source(points, quality, 4);
  std::vector<int> sets;
  source.DrawBlock(300, 4, 0, 50, Rng(1), &sets);
  // At draw 50 at most the best 54 points can come first, and each set holds such a point.
  for (std::size_t i = 0; i < sets.size(); i += 4) CHECK(sets[i] < 54);
  std::vector<int> late;
  source.DrawBlock(300, 4, 20 * 300, 50, Rng(1), &late);
  std::vector<int> prosac;
  ProsacSource(quality, 4).DrawBlock(300, 4, 20 * 300, 50, Rng(1), &prosac);
  CHECK(late == prosac);
}

TEST_CASE("Weighted sets are drawn without replacement in proportion to the weights") {
  const std::vector<double> weights{5e300, 3e300, 1.5e300, 0.5e300, 0.0, -1.0, std::nan("")};
  constexpr int kDraws = 40000;
  const std::vector<int> sets = DrawAll(WeightedSource(weights), 7, 2, kDraws);
  std::map<std::pair<int, int>, double> seen;
  for (std::size_t i = 0; i < sets.size(); i += 2) seen[{sets[i], sets[i + 1]}] += 1.0 / kDraws;
  const double share[] = {0.5, 0.3, 0.15, 0.05};
  double total = 0.0;
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b) {
      const double expected = share[a] * share[b] * (1.0 / (1.0 - share[a]) + 1.0 / (1.0 - share[b]));
      const double measured = seen[{a, b}];
      CHECK(measured == Approx(expected).margin(0.01));
      total += measured;
    }
  CHECK(total == Approx(1.0));
}

TEST_CASE("Points without weight fill up sets, and no weight at all is uniform") {
  const std::vector<int> sets = DrawAll(WeightedSource(std::vector<double>{0.0, 2.0, 0.0, 0.0, 1e-12}), 5, 3, 3000);
  std::vector<int> seen(5, 0);
  for (int index : sets) ++seen[index];
  CHECK(seen[1] == 3000);
  CHECK(seen[4] == 3000);
  for (int i : {0, 2, 3}) CHECK(seen[i] == Approx(1000).margin(120));
  const std::vector<int> uniform = DrawAll(WeightedSource(std::vector<double>(5, 0.0)), 5, 2, 5000);
  std::vector<int> counts(5, 0);
  for (int index : uniform) ++counts[index];
  for (int count : counts) CHECK(count == Approx(2000).margin(160));
}

TEST_CASE("Sources by name: missing or wrong numbers and unknown names are refused in one line") {
  const PointMatrix points = RandomPoints(10, 2, 1);
  const auto make = [&](const char* name, const std::vector<double>& quality, const std::vector<double>& weights) {
    SourceOptions options;
    options.source = name;
    return MakeHypothesisSource(options, points, 2, quality, weights);
  };
  const std::vector<double> right(10, 1.0), wrong(9, 1.0);
  CHECK_THROWS_WITH(make("prosac", {}, {}), "source prosac needs a quality for each of the 10 points, got 0 values");
  CHECK_THROWS_AS(make("prosac", wrong, {}), Error);
  CHECK_THROWS_AS(make("p_napsac", wrong, {}), Error);
  CHECK_THROWS_AS(make("weighted", right, {}), Error);
  CHECK_THROWS_AS(make("best", right, right), Error);
  CHECK_NOTHROW(make("p_napsac", {}, {}));
  const auto options = ReadOptions<SourceOptions>(Config::FromString("source: napsac\nnapsac_neighbors: 5\n"));
  CHECK(options.napsac_neighbors == 5);
  CHECK_THROWS_AS(ReadOptions<SourceOptions>(Config::FromString("source: nepsac\n")), Error);
  CHECK_THROWS_AS(ReadOptions<SourceOptions>(Config::FromString("napsac_neighbors: 0\n")), Error);
}

TEST_CASE("Non-finite or no points make harmless sources") {
  PointMatrix points = RandomPoints(10, 2, 1);
  points(3, 1) = std::numeric_limits<double>::quiet_NaN();
  for (const char* name : {"napsac", "p_napsac"}) {
    SourceOptions options;
    options.source = name;
    CHECK(DrawAll(*MakeHypothesisSource(options, points, 2), 10, 2, 5).size() == 10);
    CHECK(DrawAll(*MakeHypothesisSource(options, PointMatrix(0, 2), 2), 0, 2, 5).empty());
  }
}

}  // namespace
}  // namespace diffsac
