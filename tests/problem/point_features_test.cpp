#include "diffsac/problem/point_features.h"
#include "lab/config/yaml.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "core/errors.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"
#include "lab/data/synthetic.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

Problem MakeProblem(Task task, int points = 100, double ratio = 0.6, std::uint64_t index = 0) {
  SyntheticOptions options;
  options.num_points = points;
  options.outlier_ratio = ratio;
  return MakeSynthetic(task, options, 31)->Get(index).problem;
}

std::vector<int> DrawSets(const Problem& problem, int count) {
  const int set_size = MinimalSetSize(problem.task);
  UniformSampler source(static_cast<int>(problem.points.rows()), set_size, Rng(3));
  return diffsac::DrawSets(source, set_size, count);
}

PointFeatures Features(Task task, std::vector<PointFeature> kinds = {PointFeature::kResidual}) {
  PointFeaturesOptions options;
  options.kinds = std::move(kinds);
  return PointFeatures(options, task);
}

float Difference(const FeatureSet& a, const FeatureSet& b) { return (a.values - b.values).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("feature counts: columns, hypotheses, kept models") {
  for (Task task : {Task::kLine, Task::kPlane}) {
    const Problem problem = MakeProblem(task);
    const int d = PointDimension(task);
    CHECK(Features(task).width() == 48);
    CHECK(Features(task, {PointFeature::kCoordinates}).width() == d);
    CHECK(Features(task, {PointFeature::kResidual, PointFeature::kCoordinates}).width() == 48 + d);
    const FeatureSet both =
        Features(task, {PointFeature::kCoordinates, PointFeature::kResidual}).Compute(problem, Rng(1));
    CHECK(both.values.rows() == 100);
    CHECK(both.values.cols() == 48 + d);
    CHECK(both.values.allFinite());
    CHECK(both.hypotheses == 100);
    CHECK(both.models.size() == 16);
    CHECK(std::is_sorted(both.scores.rbegin(), both.scores.rend()));
    const FeatureSet plain = Features(task, {PointFeature::kCoordinates}).Compute(problem, Rng(1));
    CHECK(plain.hypotheses == 0);
    CHECK(plain.models.empty());
    CHECK(plain.values == both.values.leftCols(d));
  }
}

TEST_CASE("residual columns are what the header says") {
  const Problem problem = MakeProblem(Task::kLine);
  const FeatureSet features = Features(Task::kLine).Compute(problem, Rng(1));
  for (int j = 0; j < 16; ++j) {
    double score = 0.0;
    for (int i = 0; i < 100; ++i) {
      const double signed_distance = problem.points.row(i).dot(features.models[j].head(2)) + features.models[j][2];
      const double r = std::abs(signed_distance) / problem.inlier_threshold;
      CHECK(features.values(i, 3 * j) == Approx(std::exp(-2.0 * r * r)).margin(1e-5));
      CHECK(features.values(i, 3 * j + 1) == Approx(std::log1p(r) / 4.0).margin(1e-5));
      CHECK(features.values(i, 3 * j + 2) == Approx(features.scores[j] / 100.0).margin(1e-6));
      score += std::max(0.0, 1.0 - r * r / (1.5 * 1.5));
    }
    CHECK(features.scores[j] == Approx(score).epsilon(1e-9));
  }
}

TEST_CASE("the features are deterministic in the generator and change with it") {
  const Problem problem = MakeProblem(Task::kPlane);
  const PointFeatures features = Features(Task::kPlane);
  CHECK(features.Compute(problem, Rng(1)).values == features.Compute(problem, Rng(1)).values);
  CHECK(features.Compute(problem, Rng(1)).values != features.Compute(problem, Rng(2)).values);
}

TEST_CASE("permuted points with renamed sets give permuted features") {
  for (Task task : {Task::kLine, Task::kPlane}) {
    const Problem problem = MakeProblem(task, 77);
    const std::vector<int> sets = DrawSets(problem, 100);
    const PointFeatures features = Features(task, {PointFeature::kCoordinates, PointFeature::kResidual});
    const FeatureSet before = features.ComputeFromSets(NormalizedProblem(problem), sets);
    const std::vector<int> place = Rng(9).Permutation(77);  // point i moves to place[i]
    Problem moved = problem;
    for (int i = 0; i < 77; ++i) moved.points.row(place[i]) = problem.points.row(i);
    std::vector<int> renamed;
    const int size = MinimalSetSize(task);
    for (std::size_t s = 0; s < sets.size(); s += size) {
      for (int k = 0; k < size; ++k) renamed.push_back(place[sets[s + k]]);
      std::sort(renamed.end() - size, renamed.end());
    }
    FeatureSet after = features.ComputeFromSets(NormalizedProblem(moved), renamed);
    FeatureSet back = after;
    for (int i = 0; i < 77; ++i) back.values.row(i) = after.values.row(place[i]);
    CHECK(Difference(before, back) < 1e-5f);
  }
}

TEST_CASE("preference does not see rigid motions and scale, coordinates not translation and scale") {
  for (Task task : {Task::kLine, Task::kPlane}) {
    const Problem problem = MakeProblem(task);
    const std::vector<int> sets = DrawSets(problem, 100);
    const NormalizedProblem space(problem);
    Problem moved = problem;
    moved.points *= 3.0;
    moved.inlier_threshold *= 3.0;
    moved.points.col(0).array() += 40.0;
    const PointFeatures both = Features(task, {PointFeature::kCoordinates, PointFeature::kResidual});
    CHECK(Difference(both.ComputeFromSets(space, sets), both.ComputeFromSets(NormalizedProblem(moved), sets)) < 1e-4f);
    const double angle = 0.7;
    for (Eigen::Index i = 0; i < moved.points.rows(); ++i) {
      const double x = moved.points(i, 0), y = moved.points(i, 1);
      moved.points(i, 0) = std::cos(angle) * x - std::sin(angle) * y;
      moved.points(i, 1) = std::sin(angle) * x + std::cos(angle) * y;
    }
    const PointFeatures preference = Features(task);
    CHECK(Difference(preference.ComputeFromSets(space, sets),
                     preference.ComputeFromSets(NormalizedProblem(moved), sets)) < 1e-4f);
  }
}

TEST_CASE("coordinates are centred and of unit scale, against outliers too") {
  Problem problem = MakeProblem(Task::kLine, 101, 0.0);
  problem.points(0, 0) = 1e6;
  const FeatureSet features = Features(Task::kLine, {PointFeature::kCoordinates}).Compute(problem, Rng(1));
  std::vector<float> norms, xs;
  for (int i = 0; i < 101; ++i) {
    norms.push_back(features.values.row(i).norm());
    xs.push_back(features.values(i, 0));
  }
  std::sort(norms.begin(), norms.end());
  std::sort(xs.begin(), xs.end());
  CHECK(norms[50] == Approx(1.0).epsilon(1e-5));
  CHECK(xs[50] == 0.0f);
}

TEST_CASE("sets are kept once, and missing columns repeat the best hypothesis") {
  // Four points have six pairs, which 100 draws repeat many times.
  Problem problem;
  problem.points.resize(4, 2);
  problem.points << 0, 0, 1, 0.3, 2, 5, 7, 1;
  const FeatureSet features = Features(Task::kLine).Compute(problem, Rng(1));
  CHECK(features.hypotheses == 100);
  CHECK(features.models.size() == 6);
  for (int j = 6; j < 16; ++j) CHECK(features.values.middleCols(3 * j, 3) == features.values.leftCols(3));
}

TEST_CASE("degenerate points give finite features and no hypotheses") {
  for (Task task : {Task::kLine, Task::kPlane}) {
    Problem problem = MakeProblem(task, 20);
    problem.points.setConstant(2.5);
    const FeatureSet features =
        Features(task, {PointFeature::kCoordinates, PointFeature::kResidual}).Compute(problem, Rng(1));
    CHECK(features.hypotheses == 0);
    CHECK(features.models.empty());
    CHECK(features.values.isZero());
    problem.points.resize(0, PointDimension(task));
    CHECK(Features(task).Compute(problem, Rng(1)).values.rows() == 0);
    problem.points = PointMatrix::Ones(1, PointDimension(task));
    CHECK(Features(task).Compute(problem, Rng(1)).values.isZero());
  }
}

TEST_CASE("feature options are checked") {
  CHECK(ErrorOf([] { ReadOptions<PointFeaturesOptions>(ConfigFromYaml("kinds: [preferences]")); }) != "");
  CHECK(ErrorOf([] { ReadOptions<PointFeaturesOptions>(ConfigFromYaml("kinds: []")); }) != "");
  CHECK(ErrorOf([] { ReadOptions<PointFeaturesOptions>(ConfigFromYaml("residual_kept: 0")); }) != "");
}

}  // namespace diffsac
