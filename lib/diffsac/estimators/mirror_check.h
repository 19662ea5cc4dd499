#pragma once

#include <functional>

#include "diffsac/estimators/robust_estimator.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// Sets estimate->mirrored where the matches of two views hardly support a model, and do support one once the second
/// image is mirrored, left for right: then log_false_alarms is infinite, and there is no verdict and no covariance.
/// Searches at most once, and only where the estimate may be wrong or most neighbouring matches go round the other way
/// in the second image. search: of one estimate of a problem.
void CheckMirrored(const Problem& problem, const std::function<Estimate(const Problem&)>& search, Estimate* estimate);

}  // namespace diffsac
