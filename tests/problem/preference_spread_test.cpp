#include <catch2/catch.hpp>
#include <set>

#include "diffsac/problem/point_features.h"
#include "diffsac/problem/preference_features.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/plane_pair.h"
#include "lab/data/synthetic_structures.h"

namespace diffsac {
namespace {

PointFeaturesOptions Options(PreferenceChoice choice, int kept) {
  PointFeaturesOptions options;
  options.preference_draws = 300;
  options.preference_kept = kept;
  options.preference_choice = choice;
  return options;
}

// How many structures have a kept hypothesis that agrees with at least half of their points.
int StructuresSeen(const Example& example, const PointFeaturesOptions& options) {
  const PointFeatures features(options, example.problem.task);
  const FeatureSet set = features.Compute(example.problem, Rng(2));
  std::set<std::int32_t> seen;
  for (int h = 0; h < options.preference_kept; ++h) {
    const int column = features.first_preference() + kColumnsPerHypothesis * h;
    for (std::size_t k = 0; k < example.truth.structures.size(); ++k) {
      double agreement = 0.0, points = 0.0;
      for (Eigen::Index i = 0; i < set.values.rows(); ++i)
        if (example.truth.assignment[i] == static_cast<std::int32_t>(k + 1))
          agreement += set.values(i, column), ++points;
      if (agreement > 0.5 * points) seen.insert(static_cast<std::int32_t>(k));
    }
  }
  return static_cast<int>(seen.size());
}

}  // namespace

TEST_CASE("spread hypotheses see every structure where the best ones see the largest alone") {
  SyntheticStructuresOptions data;
  data.structures = {4, 3.0};
  const auto dataset = MakeSyntheticStructures(data, 5);
  int best = 0, spread = 0;
  for (int i = 0; i < 10; ++i) {
    best += StructuresSeen(dataset->Get(i), Options(PreferenceChoice::kBest, 6));
    spread += StructuresSeen(dataset->Get(i), Options(PreferenceChoice::kSpread, 6));
  }
  CHECK(spread > 30);
  CHECK(spread > best + 5);
}

TEST_CASE("the first of the spread hypotheses is the best one") {
  SyntheticStructuresOptions data;
  const Example example = MakeSyntheticStructures(data, 5)->Get(0);
  const auto first = [&](PreferenceChoice choice) {
    return PointFeatures(Options(choice, 4), Task::kLine).Compute(example.problem, Rng(2)).models.front();
  };
  CHECK(first(PreferenceChoice::kBest) == first(PreferenceChoice::kSpread));
}

TEST_CASE("neighbouring sets find more planes of two views than uniform ones") {
  int near = 0, uniform = 0;
  for (int i = 0; i < 10; ++i) {
    PointFeaturesOptions options = Options(PreferenceChoice::kSpread, 8);
    const Example example = testing::PlanePair({40, 30, 20, 15}, 60, i);
    uniform += StructuresSeen(example, options);
    options.preference_from = PreferenceDraws::kNapsac;
    near += StructuresSeen(example, options);
  }
  CHECK(near > uniform + 5);
}

TEST_CASE("first_preference is where the preference features begin") {
  PointFeaturesOptions options;
  CHECK(PointFeatures(options, Task::kLine).first_preference() == 0);
  options.kinds = {PointFeature::kCoordinates, PointFeature::kPreference};
  CHECK(PointFeatures(options, Task::kPlane).first_preference() == 3);
  options.kinds = {PointFeature::kCoordinates};
  CHECK(PointFeatures(options, Task::kLine).first_preference() == -1);
}

}  // namespace diffsac
