#pragma once

#include "lab/eval/results.h"

namespace diffsac {

/// Records what a problem is like, whatever is estimated of it, as far as its truth says:
///
///   inlier_share       share of the points that are true inliers: those of GroundTruth::inliers (labels of the data,
///                      or points within its ε of the true model); in two views without labels, where `within_px` > 0,
///                      matches whose distance from the true model (TruthDistances) is at most that
///   true_rotation_deg  two views: angle of the true motion's rotation
///   true_baseline      two views: distance of the cameras, in the unit of the source
///   true_parallax_deg  two views of known cameras: median angle between the two rays of the true inliers
///                      (GroundTruth::inliers), what the baseline is beside the depth, whatever the unit
void RecordQuantities(const Example& example, double within_px, ProblemRecord* record);

/// The share of χ² with so many degrees of freedom, 1 or more, that lies below a value of 0 or more.
double ChiSquareBelow(double value, int freedom);

/// NaN without a covariance or a true pose, and for other tasks than those of two views.
PoseLevels PoseLevelsOf(const Estimate& estimate, const Example& example);

}  // namespace diffsac
