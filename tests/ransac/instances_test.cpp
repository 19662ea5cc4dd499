#include "diffsac/ransac/instances/instances.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"

namespace diffsac {
namespace {

constexpr double kThreshold = 0.1;
constexpr InstanceSearch kSearches[] = {InstanceSearch::kSequential, InstanceSearch::kAtOnce};

struct Scene {
  PointMatrix points;
  std::vector<std::int32_t> assignment;
};

// Lines through the middle of the square, which all cross there, of `sizes` points, and uniform outliers.
Scene Star(const std::vector<int>& sizes, int outliers, std::uint64_t seed) {
  Rng rng(seed);
  Scene scene;
  int total = outliers;
  for (const int size : sizes) total += size;
  scene.points.resize(total, 2);
  int row = 0;
  for (std::size_t k = 0; k < sizes.size(); ++k)
    for (int i = 0; i < sizes[k]; ++i) {
      const double angle = std::numbers::pi * static_cast<double>(k) / static_cast<double>(sizes.size()) + 0.2;
      const double along = rng.Uniform(-5.0, 5.0), off = kThreshold / 3.0 * rng.Normal();
      scene.points.row(row++) << 5.0 + along * std::cos(angle) - off * std::sin(angle),
          5.0 + along * std::sin(angle) + off * std::cos(angle);
      scene.assignment.push_back(static_cast<std::int32_t>(k + 1));
    }
  for (int i = 0; i < outliers; ++i) {
    scene.points.row(row++) << rng.Uniform(0.0, 10.0), rng.Uniform(0.0, 10.0);
    scene.assignment.push_back(0);
  }
  return scene;
}

ConsensusOptions Options(int draws) {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.refit = Refit::kIterated;
  options.refit_rounds = 3;
  options.max_iterations = draws;
  return options;
}

InstancesResult Find(const PointMatrix& points, InstanceSearch search, int draws = 500, int most = 20) {
  InstanceSearchOptions instances;
  instances.search = search;
  instances.most = most;
  const SamplerOfRows uniform = [](const std::vector<int>& rows, int number) {
    return std::make_unique<UniformSampler>(static_cast<int>(rows.size()), 2, Rng(7).Fork("search", number));
  };
  return FindInstances<Line>(points, kThreshold, uniform, Options(draws), instances, Rng(3));
}

double ShareRight(const Scene& scene, const InstancesResult& found) {
  // By the commonest true label of each structure that was found.
  int right = 0;
  for (std::size_t k = 0; k <= found.models.size(); ++k) {
    std::vector<int> count(10, 0);
    for (std::size_t i = 0; i < scene.assignment.size(); ++i)
      if (found.assignment[i] == static_cast<std::int32_t>(k)) ++count[scene.assignment[i]];
    right += k == 0 ? count[0] : *std::max_element(count.begin() + 1, count.end());
  }
  return static_cast<double>(right) / static_cast<double>(scene.assignment.size());
}

TEST_CASE("Every search finds crossing lines of unequal size, and no others") {
  for (const InstanceSearch search : kSearches) {
    CAPTURE(ToString(search));
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const Scene scene = Star({40, 30, 20}, 30, seed);
      const InstancesResult found = Find(scene.points, search);
      REQUIRE(found.status == Status::kOk);
      CHECK(found.models.size() == 3);
      CHECK(ShareRight(scene, found) > 0.9);
    }
  }
}

TEST_CASE("Labels are the nearest model's, within the threshold, and models are ordered by their points") {
  for (const InstanceSearch search : kSearches) {
    const Scene scene = Star({30, 30, 30}, 20, 1);
    const InstancesResult found = Find(scene.points, search);
    REQUIRE(found.assignment.size() == scene.assignment.size());
    std::vector<int> sizes(found.models.size() + 1, 0);
    for (Eigen::Index i = 0; i < scene.points.rows(); ++i) {
      double least = std::numeric_limits<double>::infinity();
      std::int32_t nearest = 0;
      for (std::size_t k = 0; k < found.models.size(); ++k) {
        const double r = Line::Residual(Line::Parameters(found.models[k]), scene.points.row(i).data());
        if (r < least) least = r, nearest = static_cast<std::int32_t>(k + 1);
      }
      CHECK(found.assignment[i] == (least <= kThreshold ? nearest : 0));
      ++sizes[found.assignment[i]];
    }
    CHECK(std::is_sorted(sizes.begin() + 1, sizes.end(), std::greater<>()));
  }
}

TEST_CASE("Points without structure give an empty list and a status") {
  for (const InstanceSearch search : kSearches) {
    CAPTURE(ToString(search));
    int found = 0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const InstancesResult none = Find(Star({}, 100, seed).points, search);
      CHECK((none.status == Status::kNoModel) == none.models.empty());
      CHECK(none.assignment.size() == 100);
      CHECK((!none.models.empty() || std::count(none.assignment.begin(), none.assignment.end(), 0) == 100));
      found += static_cast<int>(none.models.size());
    }
    // log10_nfa 0 allows about one in a problem of this size, far fewer in truth: not all sets are tried.
    CHECK(found <= 3);
  }
}

TEST_CASE("No more structures are given than are asked for, nor than there are") {
  for (const InstanceSearch search : kSearches) {
    const Scene scene = Star({40, 40}, 0, 2);
    CHECK(Find(scene.points, search, 500, 1).models.size() == 1);
    CHECK(Find(scene.points, search, 500, 50).models.size() == 2);
  }
}

TEST_CASE("Too few, identical and collinear points are no reason to crash") {
  for (const InstanceSearch search : kSearches) {
    CAPTURE(ToString(search));
    for (const int count : {1, 2, 3}) CHECK(Find(Star({}, count, 1).points, search).models.empty());
    PointMatrix same(30, 2);
    same.rowwise() = Eigen::RowVector2d(1.0, 2.0);
    CHECK(Find(same, search).models.empty());
    CHECK(Find(Star({50}, 0, 1).points, search).models.size() == 1);
  }
}

TEST_CASE("Unfit points have their own status, indices out of range and priors of other lengths are passed over") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  PointMatrix unfit = Star({20}, 5, 1).points;
  unfit(3, 1) = nan;
  CHECK(Find(unfit, InstanceSearch::kAtOnce).status == Status::kDegenerate);
  CHECK(Find(PointMatrix(0, 2), InstanceSearch::kSequential).status == Status::kTooFewPoints);
  const Scene scene = Star({60}, 20, 2);
  const std::vector<int> sets = {-1, 3, 0, 1, 2, 500};
  InstanceSearchOptions instances;
  instances.search = InstanceSearch::kAtOnce;
  ConsensusOptions options = Options(3);
  options.inlier_prior_power = 1.0;
  EstimationPriors priors;
  priors.inlier_priors = Eigen::VectorXd::Constant(5, nan);
  const auto given = [&](const std::vector<int>&, int) { return std::make_unique<PrecomputedSampler>(sets); };
  CHECK(FindInstances<Line>(scene.points, kThreshold, given, options, instances, Rng(1), priors).iterations == 3);
  // Models of another kind.
  priors.models = {ModelParameters::Zero(12), ModelParameters::Constant(3, nan)};
  CHECK(FindInstances<Line>(scene.points, kThreshold, given, options, instances, Rng(1), priors).iterations == 3);
  // What is no probability: neither a crash nor a model for it.
  priors.inlier_priors = Eigen::VectorXd::Constant(80, nan);
  CHECK(FindInstances<Line>(scene.points, kThreshold, given, options, instances, Rng(1), priors).iterations == 3);
}

TEST_CASE(
    "Sets that are reported are of points that there are, when a source names others (read before the first row)") {
  const Scene scene = Star({60}, 20, 2);
  const std::vector<int> sets = {-1, 3, 0, 1, 2, 500, 4, 5};
  InstanceSearchOptions instances;
  instances.search = InstanceSearch::kSequential;
  const auto given = [&](const std::vector<int>&, int) { return std::make_unique<PrecomputedSampler>(sets); };
  const InstancesResult found = FindInstances<Line>(scene.points, kThreshold, given, Options(4), instances, Rng(1), {});
  REQUIRE(found.first_sets.size() >= 2);
  CHECK(found.first_sets[0] == std::vector<int>{0, 1});
  for (const std::vector<int>& set : found.first_sets)
    for (const int i : set) CHECK((i >= 0 && i < scene.points.rows()));
}

TEST_CASE("A model whose points turn out to be nearer to later ones is left out") {
  // Two lines that cross at a narrow angle. The first search finds the line between them, which holds the middle of
  // both; the next two find the lines themselves, by their ends.
  constexpr int kOfEach = 40;
  PointMatrix points(2 * kOfEach + 2 + 30, 2);
  Rng rng(4);
  for (int i = 0; i < kOfEach; ++i) {
    const double x = -5.0 + 10.0 * (i + 0.5) / kOfEach;
    points.row(i) << x, 0.12 * x;
    points.row(kOfEach + i) << x, -0.12 * x;
  }
  points.row(2 * kOfEach) << -1.5, 0.0;
  points.row(2 * kOfEach + 1) << 1.5, 0.0;
  for (int i = 2 * kOfEach + 2; i < points.rows(); ++i) points.row(i) << rng.Uniform(-5.0, 5.0), rng.Uniform(1.0, 9.0);
  const std::vector<std::vector<int>> sets = {
      {2 * kOfEach, 2 * kOfEach + 1}, {0, kOfEach - 1}, {kOfEach, 2 * kOfEach - 1}};
  std::vector<int> set;
  const auto given = [&](const std::vector<int>& rows, int number) {
    set.clear();
    if (number < 3)
      for (const int i : sets[number])
        set.push_back(static_cast<int>(std::find(rows.begin(), rows.end(), i) - rows.begin()));
    return std::make_unique<PrecomputedSampler>(set);
  };
  InstanceSearchOptions instances;
  instances.search = InstanceSearch::kSequential;
  instances.rounds = 0;
  ConsensusOptions options = Options(1);
  options.refit = Refit::kNone;
  const InstancesResult found = FindInstances<Line>(points, kThreshold, given, options, instances, Rng(1), {});
  REQUIRE(found.models.size() == 2);
  for (int i = 0; i < 2 * kOfEach; ++i) CHECK(found.assignment[i] == found.assignment[i < kOfEach ? 0 : kOfEach]);
}

TEST_CASE("The same seed gives the same structures, and draws are counted for each search") {
  for (const InstanceSearch search : kSearches) {
    const Scene scene = Star({30, 30, 30}, 30, 4);
    const InstancesResult a = Find(scene.points, search), b = Find(scene.points, search);
    REQUIRE(a.models.size() == b.models.size());
    for (std::size_t k = 0; k < a.models.size(); ++k) CHECK(a.models[k] == b.models[k]);
    CHECK(a.assignment == b.assignment);
    CHECK(a.iterations ==
          (search == InstanceSearch::kSequential ? 500 * (static_cast<int>(a.models.size()) + 1) : 500));
    CHECK(a.hypotheses > a.iterations);
    CHECK(a.first_sets.size() == kReportedSets);
  }
}

TEST_CASE("A chance that is said to be high takes more points to be a structure") {
  const Scene scene = Star({30, 12}, 40, 5);
  InstanceSearchOptions instances;
  instances.search = InstanceSearch::kAtOnce;
  const SamplerOfRows uniform = [](const std::vector<int>& rows, int) {
    return std::make_unique<UniformSampler>(static_cast<int>(rows.size()), 2, Rng(7));
  };
  const auto count = [&](double least_chance) {
    instances.least_chance = least_chance;
    return FindInstances<Line>(scene.points, kThreshold, uniform, Options(500), instances, Rng(3)).models.size();
  };
  CHECK(count(0.0) == 2);
  CHECK(count(0.1) == 1);
  CHECK(count(0.5) == 0);
}

TEST_CASE("Given hypotheses take part in the search at once") {
  const Scene scene = Star({40, 40}, 20, 6);
  const InstancesResult found = Find(scene.points, InstanceSearch::kAtOnce);
  REQUIRE(found.models.size() == 2);
  InstanceSearchOptions instances;
  instances.search = InstanceSearch::kAtOnce;
  const SamplerOfRows none = [](const std::vector<int>&, int) {
    return std::make_unique<PrecomputedSampler>(std::span<const int>());
  };
  EstimationPriors priors;
  priors.models = found.models;
  const InstancesResult again =
      FindInstances<Line>(scene.points, kThreshold, none, Options(1), instances, Rng(3), priors);
  CHECK(again.models.size() == 2);
  CHECK(again.assignment == found.assignment);
}

// Four walls of a room of 5 × 4 × 3, their noise σ; a cluster that is no plane; clutter everywhere.
PointMatrix Room(double sigma, int cluster, std::uint64_t seed) {
  constexpr int kWall = 400, kClutter = 100;
  const Eigen::RowVector3d size(5.0, 4.0, 3.0), center(3.2, 2.0, 1.0);
  const std::pair<int, double> walls[] = {{2, 0.0}, {0, 0.0}, {1, 0.0}, {1, 4.0}};
  Rng rng(seed);
  const auto anywhere = [&] {
    return Eigen::RowVector3d(rng.Uniform(0, size[0]), rng.Uniform(0, size[1]), rng.Uniform(0, size[2]));
  };
  PointMatrix points(4 * kWall + cluster + kClutter, 3);
  int row = 0;
  for (const auto& [axis, at] : walls)
    for (int i = 0; i < kWall; ++i) {
      points.row(row) = anywhere();
      points(row++, axis) = at + sigma * rng.Normal();
    }
  for (int i = 0; i < cluster; ++i)
    points.row(row++) = center + 0.3 * Eigen::RowVector3d(rng.Normal(), rng.Normal(), rng.Normal());
  for (int i = 0; i < kClutter; ++i) points.row(row++) = anywhere();
  return points;
}

std::size_t PlanesFound(const PointMatrix& points, double threshold, InstanceSearch search) {
  InstanceSearchOptions instances;
  instances.search = search;
  const SamplerOfRows uniform = [](const std::vector<int>& rows, int number) {
    return std::make_unique<UniformSampler>(static_cast<int>(rows.size()), 3, Rng(7).Fork("search", number));
  };
  return FindInstances<Plane>(points, threshold, uniform, Options(1000), instances, Rng(3)).models.size();
}

TEST_CASE("a room of four walls with a cluttered cluster has four planes (it gave 6 to 20)") {
  for (const InstanceSearch search : {InstanceSearch::kSequential, InstanceSearch::kAtOnce})
    for (const int cluster : {0, 300, 800})
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        CAPTURE(ToString(search), cluster, seed);
        CHECK(PlanesFound(Room(0.01, cluster, seed), 0.03, search) == 4);
      }
}

TEST_CASE("walls thicker than the threshold are one plane each (they gave 7 to 20)") {
  for (const InstanceSearch search : {InstanceSearch::kSequential, InstanceSearch::kAtOnce})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      CAPTURE(ToString(search), seed);
      CHECK(PlanesFound(Room(0.03, 300, seed), 0.03, search) == 4);
    }
}

// A wall of 5 × 3, or a line of 5, at heights of its own.
PointMatrix Wall(const Eigen::VectorXd& heights, int dimension, Rng rng) {
  PointMatrix points(heights.size(), dimension);
  for (Eigen::Index i = 0; i < heights.size(); ++i) {
    points(i, 0) = rng.Uniform(0.0, 5.0);
    points(i, 1) = heights[i];
    if (dimension == 3) points(i, 2) = rng.Uniform(0.0, 3.0);
  }
  return points;
}

template <class Model>
std::size_t SurfacesFound(const Eigen::VectorXd& heights, double threshold, InstanceSearch search, std::uint64_t seed,
                          double unit = 1.0) {
  InstanceSearchOptions instances;
  instances.search = search;
  const SamplerOfRows uniform = [](const std::vector<int>& rows, int number) {
    return std::make_unique<UniformSampler>(static_cast<int>(rows.size()), Model::kMinimalSize,
                                            Rng(7).Fork("search", number));
  };
  const PointMatrix points = unit * Wall(heights, Model::kDimension, Rng(50).Fork("wall", seed));
  return FindInstances<Model>(points, unit * threshold, uniform, Options(1000), instances, Rng(3)).models.size();
}

// Distances of the sides, and thresholds below half of them.
constexpr std::pair<double, double> kDoubleWalls[] = {{0.006, 0.0025}, {0.008, 0.003}, {0.008, 0.0035}, {0.01, 0.0035},
                                                      {0.01, 0.004},   {0.02, 0.008},  {0.02, 0.0096}};

TEMPLATE_TEST_CASE("both sides of a thin wall are found", "", Line, Plane) {
  for (const auto& [distance, threshold] : kDoubleWalls)
    for (const int count : {200, 800, 2000})
      for (const InstanceSearch search : {InstanceSearch::kSequential, InstanceSearch::kAtOnce}) {
        CAPTURE(distance, threshold, count, ToString(search));
        Rng rng(51);
        Eigen::VectorXd heights(count);
        for (Eigen::Index i = 0; i < count; ++i) heights[i] = distance * (i % 2) + 0.001 * rng.Normal();
        CHECK(SurfacesFound<TestType>(heights, threshold, search, 1) == 2);
        CHECK(SurfacesFound<TestType>(heights.reverse(), threshold, search, 1) == 2);
        CHECK(SurfacesFound<TestType>(heights, threshold, search, 2, 1000.0) == 2);
      }
}

TEMPLATE_TEST_CASE("one thick wall is found once", "", Line, Plane) {
  constexpr double kAllowed = 0.003;
  for (const double sigma : {0.3, 0.6, 1.0})
    for (const int count : {60, 200, 800})
      for (const bool uniform : {false, true})
        for (std::uint64_t seed = 0; seed < 5; ++seed) {
          CAPTURE(sigma, count, uniform, seed);
          Rng rng = Rng(52).Fork("heights", seed);
          Eigen::VectorXd heights(count);
          for (double& height : heights)
            height = kAllowed * sigma * (uniform ? std::sqrt(3.0) * rng.Uniform(-1.0, 1.0) : rng.Normal());
          CHECK(SurfacesFound<TestType>(heights, kAllowed, InstanceSearch::kAtOnce, seed) == 1);
        }
}

}  // namespace
}  // namespace diffsac
