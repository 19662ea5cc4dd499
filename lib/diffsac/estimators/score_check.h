#pragma once

#include <functional>

#include "diffsac/estimators/robust_estimator.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

// Ratios and scores may be worse than none: costs passed as scores, shuffled ones. A search by them then finds a wrong
// model or a poor one, and says so of a right one with their help. The matches show it: right ones are not the better
// scored.

/// Whether a search without the ratios or scores is worth its time, after one with them gave this estimate: it found
/// nothing that is more than chance, or its inliers are not the better scored matches, clearly where they are few. Of
/// ratios or scores that are all alike never. Takes time linear in N.
bool DoubtsScores(const Problem& problem, const Estimate& estimate);

/// Puts the estimate without the ratios or scores in the place of *estimate, that with them, where it is better
/// supported, or as well while these do not order right and wrong matches; sets scores_ignored. The costs add up.
void PreferWithoutScores(const Problem& problem, Estimate without, Estimate* estimate);

/// Searches, and where that leaves the ratios or scores in doubt once more without them; the better estimate.
Estimate SearchCheckingScores(const Problem& problem, const std::function<Estimate(const Problem&)>& search);

/// Adds what another search for the same estimate cost.
void AddCost(const EstimateReport& other, EstimateReport* report);

}  // namespace diffsac
