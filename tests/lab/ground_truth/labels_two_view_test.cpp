#include "lab/config/yaml.h"
#include "lab/ground_truth/labels.h"
#include "lab/options/options.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <set>
#include <vector>

#include "core/errors.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/synthetic_two_view.h"

namespace diffsac {
namespace {

Example MakeExample(Task task, int points, double ratio, std::uint64_t index) {
  SyntheticTwoViewOptions options;
  options.task = task;
  options.matches.num_points = points;
  options.matches.outlier_ratio = ratio;
  options.planar = 0.0;
  return MakeSyntheticTwoView(options, 31)->Get(index);
}

PointMatrix SolverPoints(const Example& example, double* pixels) {
  const Problem& problem = example.problem;
  *pixels = 1.0;
  if (problem.task != Task::kEssential) return problem.points;
  *pixels = problem.cameras->MeanFocal();
  return NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2);
}

// min(d, T) averaged over the true inliers, one residual at a time.
template <class Model>
double MeanDistance(const Example& example, const Matrix3Parameters& model, double truncation_factor) {
  double pixels = 1.0, sum = 0.0;
  const PointMatrix points = SolverPoints(example, &pixels);
  int count = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!example.truth.inliers[i]) continue;
    sum += std::min(pixels * Model::Residual(model, points.data() + 4 * i),
                    truncation_factor * example.problem.inlier_threshold);
    ++count;
  }
  return sum / count;
}

// The distance of a set by its definition, without columns, blocks and bounds.
template <class Model>
double DistanceByDefinition(const Example& example, const std::vector<int>& set, double truncation_factor) {
  double pixels = 1.0;
  const PointMatrix points = SolverPoints(example, &pixels);
  Matrix3Parameters models[Model::kMaxSolutions];
  const int solutions = Model::SolveMinimal(points, set.data(), models);
  double least = 1e300;
  for (int k = 0; k < solutions; ++k)
    least = std::min(least, MeanDistance<Model>(example, models[k], truncation_factor));
  return least;
}

double DistanceOf(const Example& example, const std::vector<int>& set, double truncation_factor = 3.0) {
  if (example.problem.task == Task::kHomography)
    return DistanceByDefinition<Homography>(example, set, truncation_factor);
  if (example.problem.task == Task::kEssential) return DistanceByDefinition<Essential>(example, set, truncation_factor);
  return set.size() == 8 ? DistanceByDefinition<Fundamental8>(example, set, truncation_factor)
                         : DistanceByDefinition<Fundamental>(example, set, truncation_factor);
}

std::vector<int> TrueInliers(const Example& example) {
  std::vector<int> inliers;
  for (int i = 0; i < static_cast<int>(example.truth.inliers.size()); ++i)
    if (example.truth.inliers[i]) inliers.push_back(i);
  return inliers;
}

struct Setting {
  Task task;
  int set_size;
};
constexpr Setting kSettings[] = {
    {Task::kHomography, 4}, {Task::kFundamental, 7}, {Task::kFundamental, 8}, {Task::kEssential, 5}};

LabelOptions OptionsOf(const Setting& setting) {
  LabelOptions options;
  if (setting.set_size == 8) options.model = "fundamental8";
  return options;
}

}  // namespace

TEST_CASE("two-view labels: sets of true inliers, ranked by the distance of the header") {
  for (const Setting& setting : kSettings)
    for (int index = 0; index < 8; ++index) {
      CAPTURE(ToString(setting.task), setting.set_size, index);
      const Example example = MakeExample(setting.task, 150, 0.5, index);
      LabelOptions options = OptionsOf(setting);
      options.truncation_factor = 2.0 + index;
      const auto found = OptimalMinimalSets(example, options, 6);
      REQUIRE(found.size() == 6);
      std::set<std::vector<int>> distinct;
      for (std::size_t i = 0; i < found.size(); ++i) {
        CHECK(static_cast<int>(found[i].points.size()) == setting.set_size);
        CHECK(std::is_sorted(found[i].points.begin(), found[i].points.end()));
        for (int point : found[i].points) CHECK(example.truth.inliers[point] == 1);
        CHECK(found[i].distance == Approx(DistanceOf(example, found[i].points, options.truncation_factor)));
        if (i > 0) CHECK(found[i].distance >= found[i - 1].distance);
        distinct.insert(found[i].points);
      }
      CHECK(distinct.size() == 6);
    }
}

TEST_CASE("two-view labels: the exhaustive optimum where the draws allow") {
  for (const Setting& setting : kSettings) {
    CAPTURE(ToString(setting.task), setting.set_size);
    const Example example = MakeExample(setting.task, 20, 0.5, 1);
    const std::vector<int> inliers = TrueInliers(example);
    REQUIRE(inliers.size() == 10);
    const auto found = OptimalMinimalSets(example, OptionsOf(setting), 5);
    REQUIRE(found.size() == 5);
    std::vector<double> all;
    for (int mask = 0; mask < 1 << 10; ++mask) {
      std::vector<int> set;
      for (int k = 0; k < 10; ++k)
        if (mask >> k & 1) set.push_back(inliers[k]);
      if (static_cast<int>(set.size()) == setting.set_size) all.push_back(DistanceOf(example, set));
    }
    std::sort(all.begin(), all.end());
    for (int i = 0; i < 5; ++i) CHECK(found[i].distance == Approx(all[i]));
  }
}

TEST_CASE("two-view labels: more draws are no worse, and the best is near the truth") {
  for (const Setting& setting : kSettings) {
    double few_sum = 0.0, many_sum = 0.0, truth_sum = 0.0;
    for (int index = 0; index < 10; ++index) {
      const Example example = MakeExample(setting.task, 200, 0.5, index);
      LabelOptions few = OptionsOf(setting), many = few;
      few.draws = 30;
      many.draws = 300;
      const double best_few = OptimalMinimalSets(example, few, 1)[0].distance;
      const double best_many = OptimalMinimalSets(example, many, 1)[0].distance;
      CHECK(best_many <= best_few);
      few_sum += best_few;
      many_sum += best_many;
      const Matrix3Parameters truth = example.truth.model;
      truth_sum += setting.task == Task::kHomography ? MeanDistance<Homography>(example, truth, 3.0)
                                                     : MeanDistance<Fundamental>(example, truth, 3.0);
    }
    CAPTURE(ToString(setting.task), setting.set_size, few_sum, many_sum, truth_sum);
    CHECK(many_sum < few_sum);
    CHECK(many_sum < 1.5 * truth_sum);
  }
}

TEST_CASE("two-view labels depend on the id, not on the place in the dataset") {
  Example example = MakeExample(Task::kFundamental, 200, 0.5, 2);
  const auto points = [&] { return OptimalMinimalSets(example, {}, 1)[0].points; };
  const auto before = points();
  example.index = 77;
  CHECK(points() == before);
  example.id = "another";
  CHECK(points() != before);
}

TEST_CASE("two-view labels: one false mark does not decide") {
  Example example = MakeExample(Task::kEssential, 200, 0.5, 4);
  const auto outlier = std::find(example.truth.inliers.begin(), example.truth.inliers.end(), 0);
  LabelOptions options;
  options.draws = 1000;
  const double before = OptimalMinimalSets(example, options, 1)[0].distance;
  *outlier = 1;
  // At most T / count more than before, and the draws differ.
  CHECK(OptimalMinimalSets(example, options, 1)[0].distance < before + 3.0 / 100.0 + 0.05);
}

TEST_CASE("two views without enough usable inliers have no label") {
  for (const Setting& setting : kSettings) {
    const Example example = MakeExample(setting.task, 60, 0.5, 6);
    const auto none = [&](const Example& e) { CHECK(OptimalMinimalSets(e, OptionsOf(setting), 3).empty()); };
    Example few = example;
    int left = setting.set_size - 1;
    for (auto& mark : few.truth.inliers) mark = mark && left-- > 0;
    none(few);
    Example unknown = example;
    unknown.truth = {};
    none(unknown);
    Example equal = example;
    equal.problem.points.rowwise() = Eigen::RowVector4d(1, 2, 3, 4);
    none(equal);
    Example broken = example;
    broken.problem.points.setConstant(std::nan(""));
    none(broken);
    Example empty = example;
    empty.problem.points.resize(0, 4);
    none(empty);
  }
  Example uncalibrated = MakeExample(Task::kEssential, 60, 0.5, 6);
  uncalibrated.problem.cameras.reset();
  CHECK(OptimalMinimalSets(uncalibrated, {}, 1).empty());
}

TEST_CASE("two views with one set of usable inliers have it for a label, where it has a model") {
  for (const Setting& setting : kSettings) {
    int labelled = 0;
    for (int index = 0; index < 8; ++index) {
      Example example = MakeExample(setting.task, 60, 0.5, index);
      int left = setting.set_size;
      for (auto& mark : example.truth.inliers) mark = mark && left-- > 0;
      const auto sets = OptimalMinimalSets(example, OptionsOf(setting), 3);
      REQUIRE(sets.size() <= 1);
      labelled += static_cast<int>(sets.size());
    }
    CAPTURE(setting.set_size);
    CHECK(labelled >= 4);
  }
}

// Hidden: prints the table of docs/generators.md.
TEST_CASE("cost of two-view labels", "[.][cost]") {
  constexpr int kProblems = 200;
  for (const Setting& setting : kSettings) {
    SyntheticTwoViewOptions data;
    data.task = setting.task;
    data.matches.num_points = 500;
    data.matches.outlier_ratio = 0.5;
    if (setting.task == Task::kHomography) data.planar = 1.0, data.general = data.mixed = data.forward = 0.0;
    const auto dataset = MakeSyntheticTwoView(data, 1);
    std::vector<Example> examples;
    for (int i = 0; i < kProblems; ++i) examples.push_back(dataset->Get(i));
    for (int draws : {100, 300, 1000}) {
      LabelOptions options = OptionsOf(setting);
      options.draws = draws;
      double best = 0.0, last = 0.0;
      const auto start = std::chrono::steady_clock::now();
      for (const Example& example : examples) {
        const auto sets = OptimalMinimalSets(example, options, 8);
        best += sets.front().distance / kProblems;
        last += sets.back().distance / kProblems;
      }
      const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
      std::printf("%s, %d points, %d draws: %.2f ms a problem, %.3f/%.3f px\n", ToString(data.task).c_str(),
                  setting.set_size, draws, elapsed.count() / kProblems, best, last);
    }
  }
}

TEST_CASE("two-view label options are checked") {
  const auto error = [](const char* yaml) { return ErrorOf([&] { ReadOptions<LabelOptions>(ConfigFromYaml(yaml)); }); };
  CHECK(Has(error("draws: 0"), "draws"));
  LabelOptions other;
  other.model = "fundamental8";
  CHECK(Has(ErrorOf([&] { OptimalMinimalSets(MakeExample(Task::kEssential, 60, 0.5, 6), other, 1); }), "fundamental8"));
  CHECK(Has(error("truncation_factor: 0"), "above 0"));
  CHECK(error("draws: 1000\ntruncation_factor: 2\n") == "");
}

}  // namespace diffsac
