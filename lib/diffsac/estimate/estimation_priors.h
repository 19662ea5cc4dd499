#pragma once

#include "diffsac/problem/normalized_problem.h"
#include "diffsac/ransac/sample_consensus.h"

namespace diffsac {

/// What the search for a problem's model may know beside its points, as the options ask for it.
EstimationPriors PriorsOfProblem(const NormalizedProblem& space, const ConsensusOptions& options);

/// The options with the noise scales of this problem.
ConsensusOptions OptionsOfProblem(const NormalizedProblem& space, ConsensusOptions options);

}  // namespace diffsac
