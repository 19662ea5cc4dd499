#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "diffsac/core/random.h"
#include "diffsac/geometry/two_view.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// The best homography of 500 sets of four of these matches by MSAC at `threshold_px`, with local optimisation and
/// Levenberg-Marquardt; empty where fewer than `fewest` matches follow it.
std::optional<Matrix3Parameters> FitDominantPlane(const PointMatrix& points, double threshold_px, int fewest,
                                                  const Rng& rng);

/// The homography that most of the true matches of a pair follow, for pairs whose truth is a pose or a fundamental
/// matrix (KITTI, where the paper trains and tests homographies and does not say with which truth): that of
/// FitDominantPlane on the matches within `threshold_px` of the true F. Depends on the matches and on `id` alone. Empty
/// where fewer than 16 matches follow it, or the truth is unknown.
std::optional<Eigen::Matrix3d> DominantHomography(const Problem& problem, const GroundTruth& truth, double threshold_px,
                                                  const std::string& id);

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

/// A label of fewer matches is no structure: four fix a homography and seven a fundamental matrix, and one more says
/// whether it holds.
int FewestLabelled(Task task);

/// Makes the labels of a pair a truth of several models of the task, homographies or fundamental matrices: of each
/// label of at least FewestLabelled matches, that of least transfer errors or Sampson distances on them: Huber's
/// loss from `loss_px` on, so that wrong labels count little, by Levenberg-Marquardt; from least squares on all, of a
/// homography from FitDominantPlane (lab/data/fitted_truth.h) where enough matches follow that. Matches of other
/// labels, and of those that fix no model, become outliers. Order, inliers, model: ArrangeStructures
/// (lab/data/instance_sizes.h); `homography` or `fundamental` is that of the largest, or empty.
void FitInstances(Task task, const Problem& problem, double loss_px, GroundTruth* truth);

/// ArrangeStructures of models of the task: what remains of them after some matches were left out.
void ArrangeInstancesOf(Task task, GroundTruth* truth);

}  // namespace diffsac
