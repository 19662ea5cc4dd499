#include "diffsac/ransac/samplers/length_consistency_sampler.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <set>

#include "geometry/cloud_scene.h"
#include "ransac/all_models.h"

namespace diffsac {
namespace {

using testing::CloudScene;
using testing::MakeCloudScene;

/// Of so many draws, how many sets hold right matches alone.
int CountRight(LengthConsistencySampler& sampler, const CloudScene& scene, int draws) {
  int right = 0;
  std::array<int, 3> set;
  for (int i = 0; i < draws; ++i) {
    REQUIRE(sampler.Next(set));
    REQUIRE(AreRows(set, scene.points.rows()));
    CHECK(std::is_sorted(set.begin(), set.end()));
    right += set[0] != set[1] &&
             std::all_of(set.begin(), set.end(), [&](int row) { return scene.inliers[static_cast<std::size_t>(row)]; });
  }
  return right;
}

}  // namespace

TEST_CASE("a draw of edges succeeds nearly as often as one match is right, or two of unknown scale") {
  for (const double wrong : {0.3, 0.8, 0.95}) {
    const CloudScene scene = MakeCloudScene(1000, wrong, 0.005, Rng(1), 2.0);
    LengthConsistencySampler pairs(scene.points, 0.03, true, {}, Rng(2));
    const double right = 1.0 - wrong;
    CAPTURE(wrong);
    CHECK(CountRight(pairs, scene, 1000) > 0.6 * right * right * 1000);
    CloudScene same = MakeCloudScene(1000, wrong, 0.005, Rng(1));
    LengthConsistencySampler single(same.points, 0.03, false, {}, Rng(2));
    CHECK(CountRight(single, same, 1000) > 0.8 * right * 1000);
    CHECK(single.DrawnPoints(3) == 1);
    CHECK(pairs.DrawnPoints(3) == 2);
  }
}

TEST_CASE("of many more matches than one draw looks at, sets are right as well") {
  const CloudScene scene = MakeCloudScene(20000, 0.97, 0.002, Rng(3));
  LengthConsistencySampler sampler(scene.points, 0.02, false, {}, Rng(4));
  CHECK(CountRight(sampler, scene, 2000) > 30);
}

TEST_CASE("matches of the best quality are drawn first, each once before any again") {
  const CloudScene scene = MakeCloudScene(200, 0.0, 0.001, Rng(5));
  std::vector<double> quality(200);
  std::iota(quality.rbegin(), quality.rend(), 0.0);
  LengthConsistencySampler sampler(scene.points, 0.01, false, quality, Rng(6));
  std::array<int, 3> set;
  for (int i = 0; i < 200; ++i) {
    REQUIRE(sampler.Next(set));
    CHECK(std::count(set.begin(), set.end(), 199 - i) >= 1);
  }
}

TEST_CASE("draws of edges depend on the seed alone, and too few matches have none") {
  const CloudScene scene = MakeCloudScene(500, 0.9, 0.01, Rng(7));
  LengthConsistencySampler one(scene.points, 0.05, false, {}, Rng(8)), same(scene.points, 0.05, false, {}, Rng(8)),
      other(scene.points, 0.05, false, {}, Rng(9));
  const std::vector<int> first = DrawSets(one, 3, 300);
  CHECK(first == DrawSets(same, 3, 300));
  CHECK(first != DrawSets(other, 3, 300));
  LengthConsistencySampler few(scene.points.topRows(2), 0.05, false, {}, Rng(8));
  CHECK(DrawSets(few, 3, 10).empty());
  LengthConsistencySampler none(scene.points.topRows(0), 0.05, false, {}, Rng(8));
  CHECK(DrawSets(none, 3, 10).empty());
  CHECK(DrawSets(one, 4, 10).empty());
}

TEST_CASE("other samplers are taken for points of no two clouds") {
  for (const MinimalSamplerKind kind :
       {MinimalSamplerKind::kLengthConsistency, MinimalSamplerKind::kLengthRatioConsistency}) {
    MinimalSamplerOptions options;
    options.sampler = kind;
    const PointMatrix points = PointMatrix::Random(20, 3);
    CHECK(DrawSets(*MakeMinimalSampler(options, points, 3, Rng(1)), 3, 10).size() == 30);
  }
}

}  // namespace diffsac
