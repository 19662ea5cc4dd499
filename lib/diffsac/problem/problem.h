#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/geometry/focal.h"
#include "diffsac/geometry/parallax.h"
#include "diffsac/geometry/points.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/rigid_motion.h"
#include "diffsac/problem/image_pair.h"

namespace diffsac {

struct FocalPosterior;
class NormalizedProblem;

/// What is estimated. The tasks are listed, and described, in problem/tasks.h.
enum class Task : int;

/// "line", "plane", "homography", "fundamental", "essential", "absolute_pose", "shared_focal", "one_focal",
/// "two_focals", "vanishing_point", "rigid", "similarity".
std::string ToString(Task task);
/// All of these.
std::vector<std::string> TaskNames();
/// Throws Error for an unknown name.
Task TaskFromString(const std::string& name);
/// γ, the size of a minimal set of the task's own model: 2 for lines, 3 for planes, 4, 7 and 5 for H, F and E, 3 for
/// poses, 2 for vanishing points, 3 for motions of clouds.
int MinimalSetSize(Task task);
/// Values in a point: 2 for lines, 3 for planes, 4 for the two-view models (x1 y1 x2 y2, pixels),
/// 5 for absolute poses (X Y Z u v), 4 for vanishing points (x1 y1 x2 y2, the ends of a segment, pixels), 6 for matches
/// of two clouds (x1 x2 x3 y1 y2 y3).
int PointDimension(Task task);
/// Whether the points are matches of two images.
bool IsTwoView(Task task);
/// The default ε in pixels: 1, for homographies 3 and for absolute poses 4. Presets are made for it: their noise scales
/// are in pixels, and suit it. Nothing else in a preset has a unit.
double DefaultThreshold(Task task);

/// Calibration matrices of the two images.
struct CameraPair {
  Eigen::Matrix3d K1 = Eigen::Matrix3d::Identity();  ///< Of the first image.
  Eigen::Matrix3d K2 = Eigen::Matrix3d::Identity();  ///< Of the second image.
  /// Pixels in one unit of normalised coordinates.
  double MeanFocal() const { return diffsac::MeanFocal(K1, K2); }
};

/// What may be known of the camera of an image whose calibration is not, in pixels; each part may be absent.
struct CameraPriorHint {
  std::optional<Eigen::Vector2d> principal_point = {};  ///< Absent: the image's centre.
  std::optional<FocalPrior> focal = {};                 ///< EXIF's, say. Absent: that of cameras in general.
  /// Task one_focal: the calibration of the image that has one.
  std::optional<Eigen::Matrix3d> K = {};
};

/// What an estimator may see of one problem. It carries no ground truth: that is the guard against leaks.
struct Problem {
  Task task{};                    ///< By default the first, lines.
  PointMatrix points;             ///< N × PointDimension(task), in the data's unit; two views: pixels.
  double inlier_threshold = 0.1;  ///< ε, in the data's unit, linear; two views: pixels.
  /// Whether ε is the task's default one in the data's unit. Noise is about as large then, and is searched for nowhere
  /// else (NoiseRangeOf).
  bool threshold_is_default = false;
  /// Two views: N numbers from 0 to 1, lower is better: matching ratios (nearest to second-nearest descriptor distance)
  /// or, where `scored`, 1 − a matcher's score; empty if unknown.
  Eigen::VectorXd snn_ratio = {};
  bool scored = false;  ///< What `snn_ratio` is. Both order matches; as probabilities they say different things.
  /// Two views: N × 2, how the keypoint of image 2 differs from that of image 1: the logarithm of the ratio of their
  /// sizes, size2 / size1, and the turn angle2 − angle1 in radians, in (−π, π], positive from the x axis towards the y
  /// axis of the image as OpenCV's KeyPoint::angle: around a right match a step Δ1 in image 1 is about
  /// Δ2 = size2 / size1 · R(turn) Δ1 in image 2. Finite; empty if unknown.
  PointMatrix scale_rotation_changes = {};
  /// Two views: where the calibration is known. The essential matrix needs it, and the absolute pose K1.
  std::optional<CameraPair> cameras = {};
  ImageSize size1 = {};  ///< Two views: of the first image, where it is known.
  ImageSize size2 = {};  ///< Of the second.
  CameraPriorHint camera_prior1 =
      {};  ///< Two views without calibration: what is known of the first camera all the same.
  CameraPriorHint camera_prior2 = {};  ///< Of the second.
  /// Two views: N × 2d, the descriptors of image 1, then those of image 2, in one row; empty when unknown or not read.
  DescriptorMatrix descriptors = {};
  /// A model to score in addition to the sampled ones, in the coordinates in which the problem is solved.
  std::optional<ModelParameters> initial_model = {};
};

/// Sets ε in pixels, and whether it is the default one.
void SetThreshold(double threshold_px, Problem* problem);

/// Whether the problem has what its task needs beside its points: the essential matrix, cameras.
bool HasItsNeeds(const Problem& problem);

/// kOk, or why no estimator can work on these points: fewer than γ, a non-finite value, or points that determine no
/// model (all equal; collinear for planes). Who goes on to estimate has a NormalizedProblem, and asks CheckSpace.
Status CheckProblem(const Problem& problem);

/// Where the points are in the (first) image, N × 2 pixels; empty for tasks without images.
PointMatrix ImagePoints(const Problem& problem);

/// How much each point says, N values in [0, 1]: a segment's length relative to the image's diagonal; empty for tasks
/// whose points say alike.
Eigen::VectorXd PointWeights(const Problem& problem);

/// The motion that a model says: of the second camera seen from the first, |t| = 1, chosen by cheirality of the inliers
/// (E, and F where the calibration is known), world-to-camera (absolute pose), or from the first cloud to the second
/// (rigid and, without its scale, similarity). Nothing for other tasks, and where no
/// choice is possible.
std::optional<RigidMotion> PoseOfEstimate(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                                          const Problem& problem);

/// The same of a problem in its solver's coordinates.
std::optional<RigidMotion> PoseOfEstimate(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                                          const NormalizedProblem& space);

/// Whether the inliers of a model determine the translation between two views, or, where there
/// are no cameras, the model. kNotTested for tasks of other points.
ParallaxTest ParallaxOfEstimate(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                                const NormalizedProblem& space);

/// The focal lengths' posteriors, in the coordinates in which the problem is solved, in pixels; nothing for tasks that
/// estimate none.
std::optional<FocalEstimate> FocalEstimateOf(const std::array<FocalPosterior, 2>& posteriors, const Problem& problem);

/// log10 of how many models chance would give with as many inliers, points of no structure thrown anywhere
/// (Log10Nfa of ransac/scores/number_of_false_alarms.h); above 0 the problem may have no model at all. threshold: what
/// an inlier is, in the data's unit.
double Log10NfaOf(const Problem& problem, int inliers, double threshold);

}  // namespace diffsac
