#pragma once

#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/core/random.h"
#include "diffsac/data/problem.h"

namespace diffsac {

struct LabelOptions {
  /// The label is drawn anew from the M best sets each time an example is seen; 1 is the paper's single optimum.
  int top_m = 1;
  /// Planes: how many triplets the bounded search may solve (lines are searched exhaustively).
  int search_budget = 2000;
  void Bind(OptionsBinder& b);
};

/// A minimal set and its distance to the ground truth.
struct RankedSet {
  std::vector<int> points;   ///< γ indices, ascending.
  double distance = 0.0;
};

/// The (up to) M sets of γ true inliers whose model is nearest to the ground-truth model, best first.
/// Distance between the two models: RMS over the true inliers of the candidate model's residual at the inlier's
/// projection onto the ground-truth model, in the data's unit. Empty when there are fewer than γ true inliers.
std::vector<RankedSet> OptimalMinimalSets(const Example& example, const LabelOptions& options, int count);

/// c_0: +1 for the points of the drawn set, −1 for the others. All −1 when there is no set.
std::vector<float> DrawLabel(const Example& example, const LabelOptions& options, Rng rng);

}  // namespace diffsac
