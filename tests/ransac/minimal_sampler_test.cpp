#include "diffsac/ransac/samplers/minimal_sampler.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"
#include "diffsac/ransac/samplers/napsac_sampler.h"
#include "diffsac/ransac/samplers/weighted_sampler.h"
#include "lab/config/yaml.h"
#include "lab/options/options.h"
#include "ransac/all_models.h"

namespace diffsac {
namespace {

bool SetsAreValid(const std::vector<int>& sets, int num_points, int set_size) {
  for (std::size_t start = 0; start < sets.size(); start += set_size)
    for (int i = 0; i < set_size; ++i) {
      const int value = sets[start + i];
      if (value < 0 || value >= num_points || (i > 0 && value <= sets[start + i - 1])) return false;
    }
  return sets.size() % set_size == 0;
}

TEST_CASE("Combinations") {
  CHECK(Combinations(100, 2) == 4950);
  CHECK(Combinations(100, 3) == 161700);
  CHECK(Combinations(5, 0) == 1);
  CHECK(Combinations(5, 5) == 1);
  CHECK(Combinations(2, 3) == 0);
  CHECK(Combinations(3, -1) == 0);
  CHECK(Combinations(1000, 500) == std::numeric_limits<std::int64_t>::max());
}

TEST_CASE("The exhaustive source gives every set once, in order") {
  for (int set_size : {1, 2, 3, 4}) {
    for (int num_points : {0, 1, 2, 3, 4, 9}) {
      ExhaustiveSampler source(num_points, set_size);
      const std::vector<int> sets = DrawSets(source, set_size, 1000);
      const int given = static_cast<int>(sets.size()) / set_size;
      CHECK(given == (num_points < set_size ? 0 : Combinations(num_points, set_size)));
      CHECK(SetsAreValid(sets, num_points, set_size));
      CHECK(CountUniqueSets(sets, set_size) == given);
    }
  }
}

TEST_CASE("The uniform source gives valid sets, all equally often") {
  constexpr int kCount = 60000;
  UniformSampler source(6, 2, Rng(3));
  const std::vector<int> sets = DrawSets(source, 2, kCount);
  REQUIRE(sets.size() == 2 * kCount);
  REQUIRE(SetsAreValid(sets, 6, 2));
  std::vector<int> seen(36, 0);
  for (std::size_t i = 0; i < sets.size(); i += 2) ++seen[sets[i] * 6 + sets[i + 1]];
  for (int a = 0; a < 6; ++a)
    for (int b = a + 1; b < 6; ++b) CHECK(seen[a * 6 + b] == Approx(4000).margin(300));
}

TEST_CASE("All sets where the budget holds them, else uniform ones") {
  CHECK(DrawAllOrSome(4, 2, 6, Rng(1)) == std::vector<int>{0, 1, 0, 2, 0, 3, 1, 2, 1, 3, 2, 3});
  UniformSampler uniform(4, 2, Rng(1));
  CHECK(DrawAllOrSome(4, 2, 5, Rng(1)) == DrawSets(uniform, 2, 5));
  CHECK(DrawAllOrSome(1, 2, 5, Rng(1)).empty());
}

TEST_CASE("A sequence gives each source its share, and goes on where one runs out") {
  const std::vector<int> few{0, 1, 0, 2}, more{3, 4, 5, 6, 7, 8};
  SequenceSampler source;
  source.Add(std::make_unique<PrecomputedSampler>(more), 2);
  source.Add(std::make_unique<PrecomputedSampler>(few), 5);
  source.Add(std::make_unique<PrecomputedSampler>(more), 0);
  source.Add(std::make_unique<ExhaustiveSampler>(3, 2));
  CHECK(DrawSets(source, 2, 100) == std::vector<int>{3, 4, 5, 6, 0, 1, 0, 2, 0, 1, 0, 2, 1, 2});
  SequenceSampler nothing;
  CHECK(DrawSets(nothing, 2, 3).empty());
}

TEST_CASE("Unique sets are counted in any order") {
  CHECK(CountUniqueSets({}, 2) == 0);
  CHECK(CountUniqueSets({0, 1, 0, 2, 1, 2}, 2) == 3);
  CHECK(CountUniqueSets({1, 2, 0, 1, 1, 2, 0, 1}, 2) == 2);
  CHECK(CountUniqueSets({1, 2, 3, 1, 2, 3}, 3) == 1);
}

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

std::vector<int> DrawAll(MinimalSampler&& source, int size, int count) { return DrawSets(source, size, count); }

TEST_CASE("Every source: valid sets, the same for the same seed, others for another, none of another size") {
  constexpr int kPoints = 60, kDraws = 100;
  const PointMatrix points = RandomPoints(kPoints, 4, 1);
  const std::vector<double> quality = RandomValues(kPoints, 2);
  for (int size : {1, 2, 7}) {
    const testing::AllSamplers sources(points, size, quality);
    for (const auto& [name, make] : sources) {
      CAPTURE(name, size);
      const std::vector<int> whole = DrawSets(*make(1), size, kDraws);
      CHECK(whole.size() == static_cast<std::size_t>(size) *
                                std::min<std::int64_t>(kDraws, name == "exhaustive" ? Combinations(kPoints, size)
                                                               : name == "confidence, maximum" && size == 1 ? kPoints
                                                                                                            : kDraws));
      int invalid = 0;
      for (std::size_t i = 0; i < whole.size(); ++i)
        invalid += whole[i] < 0 || whole[i] >= kPoints || (i % size > 0 && whole[i] <= whole[i - 1]);
      CHECK(invalid == 0);
      CHECK(DrawSets(*make(1), size, kDraws) == whole);
      const bool random = name != "exhaustive" && name != "given" && name != "confidence, maximum";
      CHECK((DrawSets(*make(2), size, kDraws) != whole) == random);
      if (name != "given") CHECK(DrawSets(*make(1), size + 1, 5).empty());
    }
    const testing::AllSamplers none(points.topRows(size - 1), size, std::vector<double>(size - 1, 1.0));
    for (const auto& [name, make] : none) CHECK(DrawSets(*make(1), size, 5).empty());
  }
}

TEST_CASE("Given sets come in order, a broken last one does not") {
  const std::vector<int> sets{4, 1, 3, 2, 9};
  CHECK(DrawAll(PrecomputedSampler(sets), 2, 10) == std::vector<int>{4, 1, 3, 2});
  CHECK(DrawAll(PrecomputedSampler({}), 2, 10).empty());
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
  const std::vector<int> sets = DrawAll(NapsacSampler(points, 3, 10, Rng(1)), 3, 2000);
  std::vector<int> clusters(5, 0);
  int mixed = 0;
  for (std::size_t i = 0; i < sets.size(); i += 3) {
    mixed += sets[i] / 20 != sets[i + 2] / 20;
    ++clusters[sets[i] / 20];
  }
  CHECK(mixed == 0);
  for (int count : clusters) CHECK(count == Approx(400).margin(80));
  // More points than neighbours: the neighbourhood is as large as it must be.
  const std::vector<int> fives = DrawAll(NapsacSampler(points, 5, 1, Rng(1)), 5, 10);
  REQUIRE(fives.size() == 50);
  const NeighborIndex index(points);
  for (auto set = fives.begin(); set != fives.end(); set += 5) {
    const bool nearest = std::any_of(set, set + 5, [&](int first) {
      std::vector<int> own = index.Nearest(first, 4);
      own.push_back(first);
      std::sort(own.begin(), own.end());
      return std::equal(own.begin(), own.end(), set);
    });
    CHECK(nearest);
  }
}

TEST_CASE("Progressive NAPSAC starts with the nearest points and ends with all") {
  const PointMatrix points = RandomPoints(200, 2, 5);
  const NeighborIndex index(points);
  const std::vector<int> sets = DrawAll(ProgressiveNapsacSampler(points, {}, 3, Rng(1), 20), 3, 6000);
  REQUIRE(sets.size() == 3 * 6000);
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
  const std::vector<int> sets = DrawAll(ProgressiveNapsacSampler(points, quality, 4, Rng(1)), 4, 20 * 300 + 50);
  // At draw 50 at most the best 54 points can come first, and each set holds such a point.
  for (std::size_t i = 0; i < 4 * 50; i += 4) CHECK(sets[i] < 54);
  const std::vector<int> prosac = DrawAll(ProsacSampler(quality, 4, Rng(1)), 4, 20 * 300 + 50);
  CHECK(std::equal(sets.begin() + 4 * 20 * 300, sets.end(), prosac.begin() + 4 * 20 * 300));
}

TEST_CASE("Weighted sets are drawn without replacement in proportion to the weights") {
  const std::vector<double> weights{5e300, 3e300, 1.5e300, 0.5e300, 0.0, -1.0, std::nan("")};
  constexpr int kDraws = 40000;
  const std::vector<int> sets = DrawAll(WeightedSampler(weights, 2, Rng(1)), 2, kDraws);
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
  const std::vector<int> sets =
      DrawAll(WeightedSampler(std::vector<double>{0.0, 2.0, 0.0, 0.0, 1e-12}, 3, Rng(1)), 3, 3000);
  std::vector<int> seen(5, 0);
  for (int index : sets) ++seen[index];
  CHECK(seen[1] == 3000);
  CHECK(seen[4] == 3000);
  for (int i : {0, 2, 3}) CHECK(seen[i] == Approx(1000).margin(120));
  const std::vector<int> uniform = DrawAll(WeightedSampler(std::vector<double>(5, 0.0), 2, Rng(1)), 2, 5000);
  std::vector<int> counts(5, 0);
  for (int index : uniform) ++counts[index];
  for (int count : counts) CHECK(count == Approx(2000).margin(160));
}

TEST_CASE("Samplers by name: missing or wrong numbers and unknown names are refused in one line") {
  const PointMatrix points = RandomPoints(10, 2, 1);
  const auto make = [&](MinimalSamplerKind source, const std::vector<double>& quality) {
    MinimalSamplerOptions options;
    options.sampler = source;
    return MakeMinimalSampler(options, points, 2, Rng(1), quality);
  };
  const std::vector<double> wrong(9, 1.0);
  CHECK_THROWS_WITH(make(MinimalSamplerKind::kProsac, {}),
                    "sampler prosac needs a matching ratio for each of the 10 points, got 0 values");
  CHECK_THROWS_AS(make(MinimalSamplerKind::kProsac, wrong), Error);
  CHECK_THROWS_AS(make(MinimalSamplerKind::kProgressiveNapsac, wrong), Error);
  CHECK_NOTHROW(make(MinimalSamplerKind::kProgressiveNapsac, {}));
  const auto options = ReadOptions<MinimalSamplerOptions>(ConfigFromYaml("sampler: napsac\nnapsac_neighbors: 5\n"));
  CHECK(options.napsac_neighbors == 5);
  for (const char* bad : {"sampler: nepsac\n", "sampler: heavy\n", "sampler: napsac\nnapsac_neighbors: 0\n",
                          "sampler: uniform\nnapsac_neighbors: 5\n"})
    CHECK_THROWS_AS(ReadOptions<MinimalSamplerOptions>(ConfigFromYaml(bad)), Error);
}

TEST_CASE("Samplers by name are the samplers of that name") {
  const PointMatrix points = RandomPoints(200, 2, 3);
  const std::vector<double> quality = RandomValues(200, 4);
  const auto named = [&](MinimalSamplerKind kind) {
    MinimalSamplerOptions options;
    options.sampler = kind;
    options.napsac_neighbors = 6;
    return DrawAll(std::move(*MakeMinimalSampler(options, points, 2, Rng(1), quality)), 2, 50);
  };
  CHECK(named(MinimalSamplerKind::kNapsac) == DrawAll(NapsacSampler(points, 2, 6, Rng(1)), 2, 50));
  CHECK(named(MinimalSamplerKind::kProgressiveNapsac) ==
        DrawAll(ProgressiveNapsacSampler(points, quality, 2, Rng(1)), 2, 50));
  CHECK(named(MinimalSamplerKind::kProsac) == DrawAll(ProsacSampler(quality, 2, Rng(1)), 2, 50));
  CHECK(named(MinimalSamplerKind::kUniform) == DrawAll(UniformSampler(200, 2, Rng(1)), 2, 50));
  CHECK(named(MinimalSamplerKind::kExhaustive) == DrawAll(ExhaustiveSampler(200, 2), 2, 50));
}

TEST_CASE("Non-finite or no points make harmless samplers") {
  PointMatrix points = RandomPoints(10, 2, 1);
  points(3, 1) = std::numeric_limits<double>::quiet_NaN();
  for (const MinimalSamplerKind kind : {MinimalSamplerKind::kNapsac, MinimalSamplerKind::kProgressiveNapsac}) {
    MinimalSamplerOptions options;
    options.sampler = kind;
    CHECK(DrawSets(*MakeMinimalSampler(options, points, 2, Rng(1)), 2, 5).size() == 10);
    CHECK(DrawSets(*MakeMinimalSampler(options, PointMatrix(0, 2), 2, Rng(1)), 2, 5).empty());
  }
}

}  // namespace
}  // namespace diffsac
