#pragma once

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/problem/solver_space.h"

namespace diffsac {

/// The probability that a match of this ratio is an inlier: so many of the mutual matches of RootSIFT lie within 3 px
/// of the refined truth, on the mean of eleven development scenes (docs/experiments.md), within .08 at every ratio.
double InlierProbabilityOfRatio(double ratio);

/// What the search for a problem's model may know beside its points, as the options ask for it.
EstimationPriors PriorsOfProblem(const SolverSpace& space, const ConsensusOptions& options);

/// The options with the noise scales of this problem.
ConsensusOptions OptionsOfProblem(const Problem& problem, ConsensusOptions options);

}  // namespace diffsac
