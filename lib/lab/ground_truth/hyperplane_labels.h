#pragma once

#include <vector>

#include "lab/ground_truth/labels.h"

namespace diffsac {

/// OptimalMinimalSets of lines and planes. Distance: RMS over the true inliers of the candidate model's residual at the
/// inlier's projection onto the ground-truth model, in the data's unit. Pairs are searched exhaustively, triplets
/// within options.search_budget. D: 2 or 3.
template <int D>
std::vector<RankedSet> OptimalHyperplaneSets(const Example& example, const LabelOptions& options, int count);

}  // namespace diffsac
