#pragma once

#include "diffsac/problem/normalized_problem.h"
#include "diffsac/ransac/sample_consensus.h"

namespace diffsac {

/// Makes what a search for a fundamental matrix found that of two photographs: of cameras with square pixels, a
/// principal point near the image's middle and a focal length of about its size. Where the sizes are equal, one length
/// and principal points in the middle come first (MarginaliseFocal), then RefinePhotographs. Leaves it where the
/// matches are against both, what other searches found, and where the images' sizes are unknown.
void PutCamerasBehind(const NormalizedProblem& space, const Rng& rng, ConsensusResult* found);

}  // namespace diffsac
