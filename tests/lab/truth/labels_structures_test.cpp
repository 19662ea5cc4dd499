#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "lab/config/yaml.h"
#include "lab/data/synthetic_plane_views.h"
#include "lab/data/synthetic_structures.h"
#include "lab/truth/labels.h"

namespace diffsac {
namespace {

Example SeveralLines(int structures, std::uint64_t index = 0) {
  SyntheticStructuresOptions options;
  options.structures.structures = structures;
  return MakeSyntheticStructures(options, 3)->Get(index);
}

}  // namespace

TEST_CASE("labels of several structures are the optimal sets of each") {
  const Example example = SeveralLines(3);
  LabelOptions options;
  const auto sets = OptimalMinimalSets(example, options, 4);
  REQUIRE(sets.size() == 12);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto own = OptimalMinimalSets(OfStructure(example, k), options, 4);
    REQUIRE(own.size() == 4);
    for (std::size_t i = 0; i < 4; ++i) {
      CHECK(sets[4 * k + i].points == own[i].points);
      for (const int point : own[i].points) CHECK(example.truth.assignment[point] == static_cast<std::int32_t>(k + 1));
    }
  }
}

TEST_CASE("homographies have label sets of each plane too") {
  SyntheticPlaneViewsOptions views;
  views.structures.structures = 3;
  const Example example = MakeSyntheticPlaneViews(views, 3)->Get(1);
  LabelOptions options;
  options.draws = 40;
  std::set<std::int32_t> labelled;
  for (const RankedSet& set : OptimalMinimalSets(example, options, 4)) {
    const std::int32_t label = example.truth.assignment[set.points.front()];
    CHECK(label > 0);
    for (const int point : set.points) CHECK(example.truth.assignment[point] == label);
    labelled.insert(label);
  }
  CHECK(labelled.size() == 3);
}

TEST_CASE("one structure of an example has its inliers and its model alone") {
  const Example example = SeveralLines(4);
  for (std::size_t k = 0; k < 4; ++k) {
    const Example one = OfStructure(example, k);
    CHECK(one.truth.model == example.truth.structures[k]);
    CHECK(one.truth.structures.empty());
    for (std::size_t i = 0; i < one.truth.inliers.size(); ++i)
      CHECK((one.truth.inliers[i] != 0) == (example.truth.assignment[i] == static_cast<std::int32_t>(k + 1)));
  }
}

TEST_CASE("whole structures as labels: all points of one, each structure once") {
  LabelOptions options;
  options.target = LabelTarget::kStructure;
  const Example several = SeveralLines(3);
  const auto sets = LabelSets(several, options);
  REQUIRE(sets.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto label = static_cast<std::int32_t>(k + 1);
    CHECK(std::count(several.truth.assignment.begin(), several.truth.assignment.end(), label) ==
          static_cast<std::int64_t>(sets[k].size()));
    for (const int point : sets[k]) CHECK(several.truth.assignment[point] == label);
  }
  const Example one = OfStructure(several, 1);
  REQUIRE(LabelSets(one, options).size() == 1);
  CHECK(LabelSets(one, options)[0] == sets[1]);
  Example none = one;
  std::fill(none.truth.inliers.begin(), none.truth.inliers.end(), 0);
  CHECK(LabelSets(none, options).empty());
}

TEST_CASE("keys of minimal sets are refused where whole structures are the labels") {
  const auto read = [](const std::string& yaml) { return ReadOptions<LabelOptions>(ConfigFromYaml(yaml, "x.yaml")); };
  CHECK_THROWS_WITH(read("target: structure\ntop_m: 4"), Catch::Contains("x.yaml:2") && Catch::Contains("target"));
  CHECK(read("target: structure").target == LabelTarget::kStructure);
}

}  // namespace diffsac
