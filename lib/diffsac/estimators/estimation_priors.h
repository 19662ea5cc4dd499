#pragma once

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/problem/solver_space.h"

namespace diffsac {

/// What the search for a problem's model may know beside its points, as the options ask for it.
EstimationPriors PriorsOfProblem(const SolverSpace& space, const ConsensusOptions& options);

/// The options with the noise scales of this problem.
ConsensusOptions OptionsOfProblem(const SolverSpace& space, ConsensusOptions options);

}  // namespace diffsac
