#pragma once

#include "diffsac/problem/normalized_problem.h"
#include "diffsac/ransac/sample_consensus.h"

namespace diffsac {

/// Makes what a search for a fundamental matrix found that of two photographs by one camera: square pixels, principal
/// points in the middles, one focal length of about the images' size. Its median takes the place of F, and its
/// posterior is found->focal. Leaves F where the matches are against that camera, and of images whose sizes differ or
/// are unknown.
void PutCameraBehind(const NormalizedProblem& space, const Rng& rng, ConsensusResult* found);

}  // namespace diffsac
