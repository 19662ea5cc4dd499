#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/rigid_motion.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// E = [t]× R.
Eigen::Matrix3d EssentialFromMotion(const RigidMotion& motion);

/// The motion without its length: t of unit length (zero stays zero).
RelativePose PoseOf(const RigidMotion& motion);

/// Fills E and F of a pair of images from what is there: E from the motion or from F and the calibration, F from E and
/// the calibration. What is already known stays.
void CompleteTruth(const Problem& problem, GroundTruth* truth);

/// The distance in pixels of each correspondence from what the source knows: the transfer error |H x1 − x2| where a
/// homography is known, else the Sampson distance to F; empty when neither is known. Infinite where it is not a number.
Eigen::VectorXd TruthDistances(const Problem& problem, const GroundTruth& truth);

/// The model of the pair's task by the matrices, poses and calibrations that the source knows; empty where it does not.
ModelParameters TrueModel(const Problem& problem, const GroundTruth& truth);

/// Of a task that is to do without a calibration: takes it from the problem, where estimators would see it, to the
/// truth. Task one_focal keeps that of the first image, as a hint. Nothing for other tasks.
void HideCalibration(Example* pair);

/// Makes the pair a problem of `task`: model and pose from what the source knows, true inliers from its labels or,
/// without labels, from TruthDistances and the threshold (ε, pixels). What is not known stays empty.
void SetTask(Task task, double inlier_threshold_px, Example* pair);

}  // namespace diffsac
