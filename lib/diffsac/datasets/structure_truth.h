#pragma once

#include "diffsac/problem/problem.h"

namespace diffsac {

/// A labelled plane of fewer matches is no structure: four fix a homography, and the fifth says whether it holds.
inline constexpr int kFewestOnPlane = 5;

/// Makes the labels of a pair a truth of several homographies: of each label of at least kFewestOnPlane matches, that
/// of least symmetric transfer errors on them: Huber's loss from `loss_px` on, so that wrong labels count little,
/// from FitDominantPlane (datasets/dominant_plane.h; the normalised DLT on all where too few follow that) by
/// Levenberg-Marquardt. Matches of other labels, and of those that fix no
/// homography, become outliers. Order, inliers, model: ArrangeStructures (generators/structure_sizes.h); `homography`
/// is that of the largest, or empty.
void FitStructures(const Problem& problem, double loss_px, GroundTruth* truth);

/// ArrangeStructures of homographies: what remains of them after some matches were left out.
void ArrangePlanes(GroundTruth* truth);

}  // namespace diffsac
