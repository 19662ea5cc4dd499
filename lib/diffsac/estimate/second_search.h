#pragma once

#include <functional>

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/prepared_problem.h"

namespace diffsac {

/// Why a second search may find what the first one missed; the first reason that holds, in this order.
enum class SearchReason {
  kNone,
  kStill,     ///< Most inliers stand still, others move (static_overlay.h): search among those that move.
  kMirrored,  ///< Neighbours change sides (mirror_check.h): search in the mirrored image.
  kScores,    ///< Inliers are not the better scored matches (score_check.h): search without scores.
  kNoise,     ///< Noise is far above where a wide range of scales begins: search with scales that suit it.
};

/// The reason for a second search after one that gave this estimate. Needs AddSupport.
SearchReason ReasonToSearch(const PreparedProblem& prepared, const Estimate& estimate);

/// Searches once more if there is a reason. If that result is the better one, diagnoses it, puts it in the place of
/// *estimate and returns true; else false, with *estimate to be diagnosed. Costs add up either way. search: one search.
bool SearchAgain(const PreparedProblem& prepared,
                 const std::function<Estimate(const NormalizedProblem&, SearchReason)>& search, Estimate* estimate);

/// The factors on noise scales, of options that are made for the task's default threshold, for this problem's. Noise
/// may be far from a threshold that is not the default one (Problem::threshold_is_default): the size of the data tells
/// where it can be, and the range is wider then. For an estimator that does not search again, and may be of other
/// scales, 1, but for matches of clouds, which have no default threshold.
NoiseRange NoiseRangeOf(const Problem& problem, bool searches_again);

}  // namespace diffsac
