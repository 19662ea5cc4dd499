#include "lab/ground_truth/labels.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "diffsac/geometry/model.h"
#include "diffsac/problem/normalized_problem.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"
#include "lab/ground_truth/best_sets.h"
#include "lab/ground_truth/task_truth.h"

namespace diffsac {

void LabelOptions::Bind(OptionsBinder& b) {
  b.Field("target", target)
      .Help(
          "which points are +1: those of an optimal minimal set, or all of one structure; the latter has no other "
          "keys");
  const bool minimal = target == LabelTarget::kMinimalSet;
  b.Field("top_m", top_m, Within(1, 1e4))
      .OnlyIf(minimal, "labels.target: minimal_set")
      .Help("the label is drawn anew from the M best sets each time an example is seen; 1: the paper's single optimum");
  b.Field("search_budget", search_budget, AtLeast(1))
      .OnlyIf(minimal, "labels.target: minimal_set")
      .Help("planes: triplets that the bounded search may solve (lines are searched exhaustively)");
  b.Field("draws", draws, Within(1, 1e6)).Help("two views: random sets of true inliers that are solved");
  b.Field("truncation_factor", truncation_factor, Positive())
      .OnlyIf(minimal, "labels.target: minimal_set")
      .Help("two views: an inlier's distance from a candidate counts at most this many ε");
}

Example OfInstance(const Example& example, std::size_t instance) {
  Example one = example;
  one.truth.instances.clear();
  one.truth.assignment.clear();
  one.truth.model = example.truth.instances[instance];
  for (std::size_t i = 0; i < example.truth.assignment.size(); ++i)
    one.truth.inliers[i] = example.truth.assignment[i] == static_cast<std::int32_t>(instance + 1);
  return one;
}

namespace {

/// The true inliers in the coordinates of the solver; the truncation in their unit.
struct TrueInliers {
  std::vector<int> index;  // of each in the problem
  PointMatrix points;
  Eigen::MatrixXd columns;  // the same, a coordinate a column
  double truncation = 0.0;
  double unit = 1.0;  // of the data's unit in one of these

  int count() const { return static_cast<int>(index.size()); }
};

/// None of a problem with points of another dimension, or without what its task needs.
TrueInliers Collect(const Example& example, const LabelOptions& options) {
  const Problem& problem = example.problem;
  const auto& marks = example.truth.inliers;
  TrueInliers inliers;
  if (!HasItsNeeds(problem) || problem.points.cols() != PointDimension(problem.task)) return inliers;
  for (int i = 0; i < static_cast<int>(std::min<std::size_t>(marks.size(), problem.points.rows())); ++i)
    if (marks[i] && problem.points.row(i).allFinite()) inliers.index.push_back(i);
  const NormalizedProblem space(problem);
  inliers.points = space.points()(inliers.index, Eigen::all);
  inliers.columns = inliers.points;
  inliers.unit = space.unit();
  inliers.truncation = options.truncation_factor * problem.inlier_threshold / inliers.unit;
  return inliers;
}

/// The mean truncated distance, in the solver's unit; infinite once it is known to exceed `bound`.
template <MinimalModel Model>
double MeanDistance(const TrueInliers& inliers, const typename Model::Parameters& model, double bound) {
  constexpr int kBlock = 64;  // between two looks at the bound
  const int count = inliers.count();
  const double* columns[Model::kDimension];
  for (int k = 0; k < Model::kDimension; ++k) columns[k] = inliers.columns.col(k).data();
  double distances[kBlock], sum = 0.0;
  for (int begin = 0; begin < count; begin += kBlock) {
    const int end = std::min(begin + kBlock, count);
    Model::Residuals(model, columns, begin, end, distances);
    // Written so that what is not a number counts as the truncation.
    for (int i = 0; i < end - begin; ++i) sum += distances[i] < inliers.truncation ? distances[i] : inliers.truncation;
    if (sum > bound * count) return std::numeric_limits<double>::infinity();
  }
  return sum / count;
}

template <MinimalModel Model>
void Offer(const TrueInliers& inliers, const std::array<int, Model::kMinimalSize>& set,
           BestSets<Model::kMinimalSize>* best) {
  typename Model::Parameters models[Model::kMaxSolutions];
  const int solutions = Model::SolveMinimal(inliers.points, set.data(), models);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < solutions; ++i)
    if (models[i].allFinite())
      least = std::min(least, MeanDistance<Model>(inliers, models[i], std::min(least, best->bound())));
  if (least < std::numeric_limits<double>::infinity()) best->Offer(least, set);
}

/// OptimalMinimalSets of a model whose sets are too many to look at all: the best of options.draws uniform ones among
/// the true inliers, or of all where there are no more.
///
/// Distance: the mean over all true inliers x of min(d(x), T), in the data's unit, with T = truncation_factor ε and d
/// the candidate's residual (of E times the mean focal length); the least over the solutions of a set. Truncated, so
/// that an inlier that is marked in error cannot decide. Cost: `draws` minimal solves, each with its solutions'
/// distances to the true inliers, which stop as soon as a set cannot be among the best `count`.
template <MinimalModel Model>
std::vector<RankedSet> BestRandomSets(const Example& example, const LabelOptions& options, int count) {
  constexpr int kSize = Model::kMinimalSize;
  const TrueInliers inliers = Collect(example, options);
  if (inliers.count() < kSize || count <= 0) return {};
  BestSets<kSize> best(count);
  const std::vector<int> sets =
      DrawAllOrSome(inliers.count(), kSize, options.draws, Rng(0).Fork("label_sets/" + example.id));
  for (std::size_t first = 0; first + kSize <= sets.size(); first += kSize) {
    std::array<int, kSize> set;
    std::copy_n(sets.begin() + static_cast<std::ptrdiff_t>(first), kSize, set.begin());
    Offer<Model>(inliers, set, &best);
  }
  std::vector<RankedSet> ranked;
  for (const auto& entry : best.entries()) {
    RankedSet set;
    for (int member : entry.set) set.points.push_back(inliers.index[member]);
    set.distance = entry.cost * inliers.unit;
    ranked.push_back(std::move(set));
  }
  return ranked;
}

std::vector<RankedSet> SetsOfOne(const Example& example, const LabelOptions& options, int count) {
  const TaskModel model = ModelFromString(example.problem.task, options.model);
  if (const auto optimal_sets = TruthOf(model.task).optimal_sets) return optimal_sets(example, options, count);
  return DispatchModel(model, [&]<class Model>() { return BestRandomSets<Model>(example, options, count); });
}

}  // namespace

std::vector<RankedSet> OptimalMinimalSets(const Example& example, const LabelOptions& options, int count) {
  if (example.truth.instances.empty()) return SetsOfOne(example, options, count);
  std::vector<RankedSet> sets;
  for (std::size_t k = 0; k < example.truth.instances.size(); ++k)
    for (RankedSet& set : SetsOfOne(OfInstance(example, k), options, count)) sets.push_back(std::move(set));
  return sets;
}

std::vector<std::vector<int>> LabelSets(const Example& example, const LabelOptions& options) {
  std::vector<std::vector<int>> sets;
  if (options.target == LabelTarget::kMinimalSet) {
    for (RankedSet& ranked : OptimalMinimalSets(example, options, options.top_m))
      sets.push_back(std::move(ranked.points));
    return sets;
  }
  const GroundTruth& truth = example.truth;
  sets.resize(std::max<std::size_t>(1, truth.instances.size()));
  for (int i = 0; i < static_cast<int>(truth.inliers.size()); ++i)
    if (truth.inliers[i] != 0) sets[truth.instances.empty() ? 0 : truth.assignment[i] - 1].push_back(i);
  std::erase_if(sets, [](const std::vector<int>& set) { return set.empty(); });
  return sets;
}

}  // namespace diffsac
