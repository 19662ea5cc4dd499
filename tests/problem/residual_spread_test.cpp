#include <catch2/catch.hpp>
#include <set>

#include "diffsac/problem/point_features.h"
#include "diffsac/problem/residual_features.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/plane_pair.h"
#include "lab/data/synthetic.h"

namespace diffsac {
namespace {

PointFeaturesOptions Options(ResidualChoice choice, int kept) {
  PointFeaturesOptions options;
  options.residual_draws = 300;
  options.residual_kept = kept;
  options.residual_choice = choice;
  return options;
}

// How many structures have a kept hypothesis that agrees with at least half of their points.
int InstancesSeen(const Example& example, const PointFeaturesOptions& options) {
  const PointFeatures features(options, example.problem.task);
  const FeatureSet set = features.Compute(example.problem, Rng(2));
  std::set<std::int32_t> seen;
  for (int h = 0; h < options.residual_kept; ++h) {
    const int column = features.first_residual() + kColumnsPerHypothesis * h;
    for (std::size_t k = 0; k < example.truth.instances.size(); ++k) {
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
  SyntheticInstancesOptions data;
  data.instances = {4, 3.0};
  const auto dataset = MakeSyntheticInstances(data, 5);
  int best = 0, spread = 0;
  for (int i = 0; i < 10; ++i) {
    best += InstancesSeen(dataset->Get(i), Options(ResidualChoice::kBest, 6));
    spread += InstancesSeen(dataset->Get(i), Options(ResidualChoice::kSpread, 6));
  }
  CHECK(spread > 30);
  CHECK(spread > best + 5);
}

TEST_CASE("the first of the spread hypotheses is the best one") {
  SyntheticInstancesOptions data;
  const Example example = MakeSyntheticInstances(data, 5)->Get(0);
  const auto first = [&](ResidualChoice choice) {
    return PointFeatures(Options(choice, 4), Task::kLine).Compute(example.problem, Rng(2)).models.front();
  };
  CHECK(first(ResidualChoice::kBest) == first(ResidualChoice::kSpread));
}

TEST_CASE("neighbouring sets find more planes of two views than uniform ones") {
  int near = 0, uniform = 0;
  for (int i = 0; i < 10; ++i) {
    PointFeaturesOptions options = Options(ResidualChoice::kSpread, 8);
    const Example example = testing::PlanePair({40, 30, 20, 15}, 60, i);
    uniform += InstancesSeen(example, options);
    options.residual_from = ResidualDraws::kNapsac;
    near += InstancesSeen(example, options);
  }
  CHECK(near > uniform + 5);
}

TEST_CASE("first_residual is where the residual features begin") {
  PointFeaturesOptions options;
  CHECK(PointFeatures(options, Task::kLine).first_residual() == 0);
  options.kinds = {PointFeature::kCoordinates, PointFeature::kResidual};
  CHECK(PointFeatures(options, Task::kPlane).first_residual() == 3);
  options.kinds = {PointFeature::kCoordinates};
  CHECK(PointFeatures(options, Task::kLine).first_residual() == -1);
}

}  // namespace diffsac
