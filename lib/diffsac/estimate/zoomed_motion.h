#pragma once

#include <optional>

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/normalized_problem.h"

namespace diffsac {

/// Two views whose focal lengths have an unknown ratio: images grow by a motion ahead as they do by a zoom, so that
/// another ratio makes of a motion along the optical axis one that goes the other way. That motion, if it is less than
/// 20 times less likely by matches and prior than the estimate's.
std::optional<RigidMotion> MotionOfOtherRatio(const NormalizedProblem& solved, const Estimate& estimate);

}  // namespace diffsac
