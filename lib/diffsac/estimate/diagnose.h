#pragma once

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/prepared_problem.h"

namespace diffsac {

/// Sets what decides whether a search was good enough: the inliers' threshold, log10_nfa, and the status of rows
/// that are all alike.
void AddSupport(const PreparedProblem& prepared, Estimate* estimate);

/// Completes the estimate that is returned, once: the pose, what the inliers determine (`degeneracy`, `turn`), a
/// plane's other motion, error_probability and posteriors. A result that chance explains has no verdict, and neither
/// covariance nor other motion. Needs AddSupport.
void Diagnose(const PreparedProblem& prepared, Estimate* estimate);

/// Estimate::pose, also of an estimate that did not come from a RobustEstimator (the oracle's, a recorded one).
std::optional<RigidMotion> PoseOfEstimate(const Estimate& estimate, const Problem& problem);

}  // namespace diffsac
