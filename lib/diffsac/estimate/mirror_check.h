#pragma once

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// Whether most neighbouring matches go round the other way in the second image, as those of a mirrored photograph do.
/// Not for matches that lie on a line.
bool MayBeMirrored(const NormalizedProblem& space, const Estimate& estimate);

/// The problem with the second image mirrored, left for right.
Problem Mirrored(const Problem& problem);

/// Whether an estimate of the mirrored problem explains the matches better: about as many inliers, or more, clearly
/// more than chance. Needs Diagnose of `mirrored`.
bool IsBetterMirrored(const Estimate& mirrored, const Estimate& estimate);

/// Makes an estimate one of mirrored matches: log10_nfa is infinite, there is no verdict and no covariance.
void SetMirrored(Estimate* estimate);

}  // namespace diffsac
