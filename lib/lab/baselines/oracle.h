#pragma once

#include "diffsac/estimate/robust_estimator.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// The ceiling: least squares on the true inliers. The only estimate that is shown the ground truth. kNoModel when the
/// truth lists no inliers for every point, or when they determine no model.
Estimate OracleEstimate(const Problem& problem, const GroundTruth& truth);

}  // namespace diffsac
