#pragma once

#include <vector>

#include "diffsac/data/labels.h"

namespace diffsac {

/// OptimalMinimalSets of homographies, fundamental and essential matrices. Cost: `draws` minimal solves, each with its
/// solutions' distances to the true inliers, which stop as soon as a set cannot be among the best `count`.
std::vector<RankedSet> OptimalTwoViewSets(const Example& example, const LabelOptions& options, int count);

}  // namespace diffsac
