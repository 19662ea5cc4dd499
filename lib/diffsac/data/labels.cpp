#include "diffsac/data/labels.h"

#include "diffsac/data/random_labels.h"
#include "diffsac/data/tasks.h"

namespace diffsac {

void LabelOptions::Bind(OptionsBinder& b) {
  b.Field("top_m", top_m, AtLeast(1))
      .Help("the label is drawn anew from the M best sets each time an example is seen; 1: the paper's single optimum");
  b.Field("search_budget", search_budget, AtLeast(1))
      .Help("planes: triplets that the bounded search may solve (lines are searched exhaustively)");
  b.Field("draws", draws, AtLeast(1)).Help("two views: random sets of true inliers that are solved");
  b.Field("truncation_factor", truncation_factor, Positive())
      .Help("two views: an inlier's distance from a candidate counts at most this many ε");
}

Example OfStructure(const Example& example, std::size_t structure) {
  Example one = example;
  one.truth.structures.clear();
  one.truth.labels.clear();
  one.truth.model = example.truth.structures[structure];
  for (std::size_t i = 0; i < example.truth.labels.size(); ++i)
    one.truth.inliers[i] = example.truth.labels[i] == static_cast<std::int32_t>(structure + 1);
  return one;
}

namespace {

std::vector<RankedSet> SetsOfOne(const Example& example, const LabelOptions& options, int count) {
  const TaskModel model = ModelFromString(example.problem.task, options.model);
  return DispatchDescription(model.task, [&]<TaskDescription Description>() {
    if constexpr (requires { Description::OptimalSets(example, options, count); })
      return Description::OptimalSets(example, options, count);
    else
      return DispatchModel(model, [&]<class Model>() { return BestRandomSets<Model>(example, options, count); });
  });
}

}  // namespace

std::vector<RankedSet> OptimalMinimalSets(const Example& example, const LabelOptions& options, int count) {
  if (example.truth.structures.empty()) return SetsOfOne(example, options, count);
  std::vector<RankedSet> sets;
  for (std::size_t k = 0; k < example.truth.structures.size(); ++k)
    for (RankedSet& set : SetsOfOne(OfStructure(example, k), options, count)) sets.push_back(std::move(set));
  return sets;
}

}  // namespace diffsac
