#pragma once

#include <optional>

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/normalized_problem.h"

namespace diffsac {

/// The reversed motion along the optical axis of two views with an unknown ratio of focal lengths. Moving ahead and
/// zooming enlarge an image alike, so that another ratio can reverse the motion. Returns it if matches and priors make
/// it less than 20 times less likely than the estimate's.
std::optional<RigidMotion> MotionOfOtherRatio(const NormalizedProblem& solved, const Estimate& estimate);

}  // namespace diffsac
