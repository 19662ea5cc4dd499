#include "lab/ground_truth/labels.h"

#include <algorithm>
#include <utility>

#include "diffsac/problem/tasks.h"
#include "lab/ground_truth/random_labels.h"
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
