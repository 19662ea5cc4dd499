#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/rigid_motion.h"
#include "lab/ground_truth/estimate_error.h"
#include "lab/ground_truth/labels.h"
#include "lab/ground_truth/linear_equations.h"

namespace diffsac {

/// What needs the truth of a task, beside the library's description of it (diffsac/problem/task_description.h): one
/// entry a task in the table of task_truth.cpp.
struct TaskTruth {
  /// How wrong an estimate is; model is null for a failure, else finite and of the task's size.
  EstimateError (*error)(const ModelParameters* model, const std::vector<std::uint8_t>& inliers,
                         const Example& example) = nullptr;
  bool error_in_pixels = false;  ///< The tables are about error_px, else about angle_deg.

  // Null where a task has none:

  /// The model by what the source of a pair of images knows (TrueModel of pair_truth.h).
  ModelParameters (*true_model)(const Problem& problem, const GroundTruth& truth) = nullptr;
  /// The angle between two models in degrees, for several structures (lab/ground_truth/instances_error.h).
  double (*instance_angle)(const ModelParameters& a, const ModelParameters& b, const Example& example) = nullptr;
  /// The minimal sets of true inliers nearest to the truth (labels.h). Null: the best of random ones by the models' own
  /// residuals.
  std::vector<RankedSet> (*optimal_sets)(const Example& example, const LabelOptions& options, int count) = nullptr;
  /// The weighted linear fit that gradients pass through (CLNet).
  LinearEquations (*equations)(const NormalizedProblem& space, const GroundTruth& truth) = nullptr;
};
const TaskTruth& TruthOf(Task task);

/// Whether the task's tables are about errors in pixels, not in degrees.
bool ErrorInPixels(Task task);

/// The mean distance |H x − H_true x| over JointlyVisiblePixels; over a 10 × 10 grid on the box of the matches in image
/// 1 where the images' sizes are unknown or nothing is visible in both; NaN without a true homography. Where the pose
/// and the calibration are known also the least error among the motions into which H decomposes.
EstimateError HomographyError(const ModelParameters* model, const std::vector<std::uint8_t>& inliers,
                              const Example& example);

/// Adds the errors of the motion that a person is given (PoseOfEstimate of the estimate), whatever the model allows
/// beside it (docs/metrics.md#the-pose-that-is-given). Adds nothing where no such motion can be judged: without a true
/// pose, of other tasks than those of two views, and of F and H without cameras.
void AddPoseError(const std::optional<RigidMotion>& pose, const Example& example, EstimateError* error);

/// The step of the grid that stands for all pixels.
inline constexpr int kVisibleStep = 4;

/// The pixels of image 1 (every kVisibleStep-th in both directions, from kVisibleStep / 2 on) that the true homography
/// takes into image 2, in front of the plane's horizon: the part of the plane that both images show (the CVPR 2020
/// RANSAC tutorial's homography error, there over every pixel). Empty without both images' sizes or a true homography.
std::vector<Eigen::Vector2d> JointlyVisiblePixels(const Example& example);

/// N values: 1 for points within the inlier threshold under this pose.
std::vector<std::uint8_t> AbsolutePoseInliers(const Problem& problem, const AbsolutePose::Parameters& pose);

}  // namespace diffsac
