#pragma once

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

// Ratios and scores may be worse than none: costs passed as scores, shuffled ones. A search by them then finds a wrong
// model or a poor one, and says so of a right one with their help. The matches show it: right ones are not the better
// scored.

/// Whether a search without the ratios or scores is worth its time, after one with them gave this estimate: it found
/// nothing that is more than chance, or its inliers are not the better scored matches, clearly where they are few. Of
/// ratios or scores that are all alike never. Takes time linear in N.
bool DoubtsScores(const Problem& problem, const Estimate& estimate);

/// Whether the estimate without the ratios or scores of the problem is better than that with them: better supported,
/// or as well while these do not order right and wrong matches.
bool IsBetterWithoutScores(const Problem& problem, const Estimate& without, const Estimate& with);

}  // namespace diffsac
