#pragma once

#include "lab/truth/example.h"

namespace diffsac {

/// A label of fewer matches is no structure: four fix a homography and seven a fundamental matrix, and one more says
/// whether it holds.
int FewestLabelled(Task task);

/// Makes the labels of a pair a truth of several models of the task, homographies or fundamental matrices: of each
/// label of at least FewestLabelled matches, that of least transfer errors or Sampson distances on them: Huber's
/// loss from `loss_px` on, so that wrong labels count little, by Levenberg-Marquardt; from least squares on all, of a
/// homography from FitDominantPlane (lab/data/dominant_plane.h) where enough matches follow that. Matches of other
/// labels, and of those that fix no model, become outliers. Order, inliers, model: ArrangeStructures
/// (lab/data/structure_sizes.h); `homography` or `fundamental` is that of the largest, or empty.
void FitStructures(Task task, const Problem& problem, double loss_px, GroundTruth* truth);

/// ArrangeStructures of models of the task: what remains of them after some matches were left out.
void ArrangeStructuresOf(Task task, GroundTruth* truth);

}  // namespace diffsac
