#pragma once

#include <functional>

#include "diffsac/estimators/robust_estimator.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// Sets estimate->mirrored where most neighbouring matches go round the other way in the second image, and about as
/// many as the estimate's inliers, or more, fit a model once that image is mirrored, left for right: then
/// log_false_alarms is infinite, and there is no verdict and no covariance. Searches at most once, and only there.
/// search: of one estimate of a problem.
void CheckMirrored(const Problem& problem, const std::function<Estimate(const Problem&)>& search, Estimate* estimate);

}  // namespace diffsac
