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

std::vector<RankedSet> OptimalMinimalSets(const Example& example, const LabelOptions& options, int count) {
  const TaskModel model = ModelFromString(example.problem.task, options.model);
  return DispatchDescription(model.task, [&]<TaskDescription Description>() {
    if constexpr (requires { Description::OptimalSets(example, options, count); })
      return Description::OptimalSets(example, options, count);
    else
      return DispatchModel(model, [&]<class Model>() { return BestRandomSets<Model>(example, options, count); });
  });
}

}  // namespace diffsac
