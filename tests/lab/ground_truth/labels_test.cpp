#include "lab/ground_truth/labels.h"
#include "lab/options/options.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/yaml.h"
#include "lab/data/plane_pair.h"
#include "lab/data/synthetic.h"
#include "lab/ground_truth/best_sets.h"

namespace diffsac {
namespace {

Example MakeExample(Task task, int points, double ratio, std::uint64_t index) {
  SyntheticOptions options;
  options.num_points = points;
  options.outlier_ratio = ratio;
  return MakeSynthetic(task, options, 21)->Get(index);
}

// The distance by its definition, one inlier at a time: an independent route to what labels.cpp gets from moments.
template <class Model>
double DistanceByDefinition(const Example& example, const std::vector<int>& set) {
  typename Model::Parameters candidate;
  if (Model::SolveMinimal(example.problem.points, set.data(), &candidate) == 0) return 1e300;
  constexpr int kD = Model::kDimension;
  const auto& truth = example.truth.model;
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index i = 0; i < example.problem.points.rows(); ++i) {
    if (!example.truth.inliers[i]) continue;
    Eigen::VectorXd p = example.problem.points.row(i);
    p -= (p.dot(truth.head(kD)) + truth[kD]) * truth.head(kD);
    sum += std::pow(Model::Residual(candidate, p.data()), 2);
    ++count;
  }
  return std::sqrt(sum / count);
}

std::vector<int> TrueInliers(const Example& example) {
  std::vector<int> inliers;
  for (int i = 0; i < static_cast<int>(example.truth.inliers.size()); ++i)
    if (example.truth.inliers[i]) inliers.push_back(i);
  return inliers;
}

std::vector<RankedSet> Sorted(std::vector<RankedSet> sets) {
  std::sort(sets.begin(), sets.end(), [](const auto& a, const auto& b) { return a.distance < b.distance; });
  return sets;
}

std::vector<RankedSet> AllSets(const Example& example) {
  const std::vector<int> in = TrueInliers(example);
  std::vector<RankedSet> sets;
  for (std::size_t i = 0; i < in.size(); ++i)
    for (std::size_t j = i + 1; j < in.size(); ++j) {
      if (example.problem.task == Task::kLine) {
        const std::vector<int> set = {in[i], in[j]};
        sets.push_back({set, DistanceByDefinition<Line>(example, set)});
        continue;
      }
      for (std::size_t k = j + 1; k < in.size(); ++k) {
        const std::vector<int> set = {in[i], in[j], in[k]};
        sets.push_back({set, DistanceByDefinition<Plane>(example, set)});
      }
    }
  return Sorted(sets);
}

void CheckAgainstAll(const Example& example, const LabelOptions& options, int count) {
  const auto found = OptimalMinimalSets(example, options, count);
  const auto all = AllSets(example);
  REQUIRE(found.size() == std::min<std::size_t>(count, all.size()));
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].distance == Approx(all[i].distance).epsilon(1e-6).margin(1e-9));
    CHECK(std::is_sorted(found[i].points.begin(), found[i].points.end()));
    for (int point : found[i].points) CHECK(example.truth.inliers[point] == 1);
  }
  CHECK(found[0].points == all[0].points);
}

}  // namespace

TEST_CASE("line labels are the exhaustive optimum, ranked") {
  for (int i = 0; i < 20; ++i) CheckAgainstAll(MakeExample(Task::kLine, 60, 0.4, i), {}, 10);
  CheckAgainstAll(MakeExample(Task::kLine, 10, 0.5, 0), {}, 100);  // more asked than there are
}

TEST_CASE("plane labels are the exhaustive optimum where the budget allows") {
  for (int i = 0; i < 10; ++i) CheckAgainstAll(MakeExample(Task::kPlane, 40, 0.5, i), {}, 8);
}

TEST_CASE("the bounded plane search finds the exhaustive optimum in 95 % of problems") {
  LabelOptions bounded, exhaustive;
  exhaustive.search_budget = 1 << 30;
  int optimal = 0, near = 0;
  const int problems = 200;
  for (int i = 0; i < problems; ++i) {
    const int points = i % 2 == 0 ? 100 : 60;
    const Example example = MakeExample(Task::kPlane, points, 0.1 + 0.1 * (i % 4), i);
    const double best = OptimalMinimalSets(example, exhaustive, 1)[0].distance;
    const auto found = OptimalMinimalSets(example, bounded, 1);
    REQUIRE(found.size() == 1);
    CHECK(found[0].distance >= best * (1.0 - 1e-9));
    CHECK(found[0].distance == Approx(DistanceByDefinition<Plane>(example, found[0].points)).epsilon(1e-6));
    optimal += found[0].distance <= best * (1.0 + 1e-9);
    near += found[0].distance <= 1.5 * best;
  }
  CHECK(optimal >= 0.95 * problems);
  CHECK(near >= 0.99 * problems);
}

TEST_CASE("the bounded search stays ranked and distinct") {
  const Example example = MakeExample(Task::kPlane, 200, 0.2, 1);
  const auto found = OptimalMinimalSets(example, {}, 32);
  REQUIRE(found.size() == 32);
  std::set<std::vector<int>> distinct;
  for (std::size_t i = 0; i < found.size(); ++i) {
    distinct.insert(found[i].points);
    if (i > 0) CHECK(found[i].distance >= found[i - 1].distance);
  }
  CHECK(distinct.size() == 32);
}

TEST_CASE("without enough usable inliers there is no set") {
  for (Task task : {Task::kLine, Task::kPlane}) {
    Example example = MakeExample(task, 20, 0.2, 0);
    const auto none = [&](const Example& e) { CHECK(OptimalMinimalSets(e, {}, 3).empty()); };
    Example few = example;
    int left = MinimalSetSize(task) - 1;
    for (auto& mark : few.truth.inliers) mark = mark && left-- > 0;
    none(few);
    Example unknown = example;
    unknown.truth = {};
    none(unknown);
    Example equal = example;
    equal.problem.points.setConstant(4.0);
    none(equal);
    Example empty = example;
    empty.problem.points.resize(0, PointDimension(task));
    empty.truth.inliers.clear();
    none(empty);
    Example broken = example;
    broken.problem.points.setConstant(std::nan(""));
    none(broken);
  }
}

namespace {

Example SeveralLines(int instances, std::uint64_t index = 0) {
  SyntheticInstancesOptions options;
  options.instances.instances = instances;
  return MakeSyntheticInstances(options, 3)->Get(index);
}

}  // namespace

TEST_CASE("labels of several structures are the optimal sets of each") {
  const Example example = SeveralLines(3);
  LabelOptions options;
  const auto sets = OptimalMinimalSets(example, options, 4);
  REQUIRE(sets.size() == 12);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto own = OptimalMinimalSets(OfInstance(example, k), options, 4);
    REQUIRE(own.size() == 4);
    for (std::size_t i = 0; i < 4; ++i) {
      CHECK(sets[4 * k + i].points == own[i].points);
      for (const int point : own[i].points) CHECK(example.truth.assignment[point] == static_cast<std::int32_t>(k + 1));
    }
  }
}

TEST_CASE("homographies have label sets of each plane too") {
  const Example example = testing::PlanePair({40, 30, 20}, 60, 3);
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
    const Example one = OfInstance(example, k);
    CHECK(one.truth.model == example.truth.instances[k]);
    CHECK(one.truth.instances.empty());
    for (std::size_t i = 0; i < one.truth.inliers.size(); ++i)
      CHECK((one.truth.inliers[i] != 0) == (example.truth.assignment[i] == static_cast<std::int32_t>(k + 1)));
  }
}

TEST_CASE("whole structures as labels: all points of one, each structure once") {
  LabelOptions options;
  options.target = LabelTarget::kInstance;
  const Example several = SeveralLines(3);
  const auto sets = LabelSets(several, options);
  REQUIRE(sets.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto label = static_cast<std::int32_t>(k + 1);
    CHECK(std::count(several.truth.assignment.begin(), several.truth.assignment.end(), label) ==
          static_cast<std::int64_t>(sets[k].size()));
    for (const int point : sets[k]) CHECK(several.truth.assignment[point] == label);
  }
  const Example one = OfInstance(several, 1);
  REQUIRE(LabelSets(one, options).size() == 1);
  CHECK(LabelSets(one, options)[0] == sets[1]);
  Example none = one;
  std::fill(none.truth.inliers.begin(), none.truth.inliers.end(), 0);
  CHECK(LabelSets(none, options).empty());
}

TEST_CASE("keys of minimal sets are refused where whole structures are the labels") {
  const auto read = [](const std::string& yaml) { return ReadOptions<LabelOptions>(ConfigFromYaml(yaml, "x.yaml")); };
  CHECK_THROWS_WITH(read("target: structure\ntop_m: 4"), Catch::Contains("x.yaml:2") && Catch::Contains("target"));
  CHECK(read("target: structure").target == LabelTarget::kInstance);
}

TEST_CASE("the best sets are the same in whatever order they come, those of one cost too") {
  using Set = std::array<int, 2>;
  std::vector<std::pair<double, Set>> offers;
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j) offers.push_back({static_cast<double>((i + j) % 3), {i, j}});
  auto sorted = offers;
  std::sort(sorted.begin(), sorted.end());
  Rng rng(4);
  for (int trial = 0; trial < 50; ++trial) {
    for (std::size_t k = offers.size(); k > 1; --k) std::swap(offers[k - 1], offers[rng.Below(k)]);
    BestSets<2> best(7);
    CHECK(best.bound() == std::numeric_limits<double>::infinity());
    for (const auto& [cost, set] : offers) best.Offer(cost, set);
    best.Offer(sorted[3].first, sorted[3].second);  // Known already.
    REQUIRE(best.entries().size() == 7);
    for (std::size_t k = 0; k < 7; ++k) {
      CHECK(best.entries()[k].cost == sorted[k].first);
      CHECK(best.entries()[k].set == sorted[k].second);
    }
    CHECK(best.bound() == sorted[6].first);
  }
  BestSets<2> none(0);
  none.Offer(1.0, {0, 1});
  CHECK(none.entries().empty());
}

}  // namespace diffsac
