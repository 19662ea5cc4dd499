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
  /// Two views: how many random sets of true inliers are solved.
  int draws = 300;
  /// Two views: an inlier's distance from a candidate counts at most this many ε.
  double truncation_factor = 3.0;
  /// Fundamental matrices: 7 or 8 points a set, solved by the 7-point or the 8-point algorithm.
  int fundamental_points = 7;
  void Bind(OptionsBinder& b);
};

/// A minimal set and its distance to the ground truth.
struct RankedSet {
  std::vector<int> points;  ///< γ indices, ascending.
  double distance = 0.0;
};

/// The (up to) M sets of γ true inliers whose model is nearest to the ground-truth model, best first. Empty when there
/// are fewer than γ true inliers.
///
/// Distance of lines and planes: RMS over the true inliers of the candidate model's residual at the inlier's projection
/// onto the ground-truth model, in the data's unit.
///
/// Distance of two-view models: the mean over all true inliers x of min(d(x), T), in pixels, with T = truncation_factor
/// ε and d the Sampson distance (F, E; E times the mean focal length) or the symmetric transfer error (H) of the
/// candidate; the least over the solutions of a set. Truncated, so that an inlier that is marked in error cannot
/// decide. The sets are `draws` uniform ones among the true inliers, or all of them where there are no more; they
/// depend on the example's id alone, so an example has the same sets in every epoch.
std::vector<RankedSet> OptimalMinimalSets(const Example& example, const LabelOptions& options, int count);

/// c_0: +1 for the points of the drawn set, −1 for the others. All −1 when there is no set.
std::vector<float> DrawLabel(const Example& example, const LabelOptions& options, Rng rng);

}  // namespace diffsac
