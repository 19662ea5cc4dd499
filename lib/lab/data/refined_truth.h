#pragma once

#include "lab/truth/example.h"

namespace diffsac {

/// Replaces the true E and F by those that fit the matches near them best. Poses of vehicles and of hand-held cameras
/// are often pixels off, so that correct matches are called outliers (KITTI, ten frames apart: of the 20 matches of
/// lowest ratio 51 % lie within 1 px of the given truth, 89 % of the refined one). Levenberg-Marquardt on truncated
/// Sampson distances from the given truth, over the matches within 2 `loss_px` of it, truncated at `loss_px`; in
/// normalised coordinates where the calibration is known. Nothing changes where a homography is known, where fewer than
/// 16 matches are near, or where the refined model has fewer matches within `loss_px` than the given one. The motion
/// stays what it was: errors of poses are measured against the source's.
void RefineEpipolarTruth(const Problem& problem, double loss_px, GroundTruth* truth);

/// By how many degrees (the larger of rotation and direction) the pose of a calibrated pair turns when it is refined
/// thrice like this: what the matches disagree with the source by. Infinite where fewer than `near` matches are within
/// loss_px of the truth before or after, NaN where pose or calibration are unknown.
double TruthDisagreementDegrees(const Problem& problem, const GroundTruth& truth, double loss_px, int near);

}  // namespace diffsac
