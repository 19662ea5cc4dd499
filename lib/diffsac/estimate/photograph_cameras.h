#pragma once

#include "diffsac/problem/normalized_problem.h"
#include "diffsac/ransac/sample_consensus.h"

namespace diffsac {

/// Replaces the fundamental matrix that a search found by that of one camera: square pixels, principal points at the
/// image centres, one focal length. The focal length is the median of its posterior, which becomes found->focal. Keeps
/// the matrix if the matches contradict such a camera, or if the image sizes differ or are unknown.
void PutCameraBehind(const NormalizedProblem& space, const Rng& rng, ConsensusResult* found);

}  // namespace diffsac
