#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "diffsac/core/enum_names.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/geometry/degeneracy.h"
#include "diffsac/geometry/focal.h"
#include "diffsac/geometry/rigid_motion.h"
#include "diffsac/geometry/vanishing_camera.h"
#include "diffsac/problem/problem.h"

// Results of the functions in diffsac.h.
namespace diffsac {

/// Whether a result may be used. If several hold, the first.
enum class Verdict {
  kFailed,       ///< "failed": no model; Status says why.
  kUnsupported,  ///< "unsupported": no more inliers than unrelated points would give. Do not use it.
  /// "unreliable": E, F: more often wrong than right, by more than 10° in R or t; or the matches contradict the focal
  /// lengths that were given (Diagnostics::focal_conflict).
  kUnreliable,
  kRotationOnly,  ///< "rotation_only": the camera only rotated, or did not move: R is right, t is 0.
  kPlanar,        ///< "planar": the inliers lie on one plane (F) or line: they are right, the model is one of many.
  kAmbiguous,     ///< "ambiguous": two poses explain the inliers, `pose` and `ambiguous_pose`.
  kReliable       ///< "reliable".
};
/// Their names.
template <>
inline constexpr auto kEnumNames<Verdict> = NamesOf<Verdict>({{Verdict::kFailed, "failed"},
                                                              {Verdict::kUnsupported, "unsupported"},
                                                              {Verdict::kUnreliable, "unreliable"},
                                                              {Verdict::kRotationOnly, "rotation_only"},
                                                              {Verdict::kPlanar, "planar"},
                                                              {Verdict::kAmbiguous, "ambiguous"},
                                                              {Verdict::kReliable, "reliable"}});

/// The numbers behind a verdict.
struct Diagnostics {
  /// log10 of the number of false alarms: models with as many inliers that are expected by chance. Above 0:
  /// kUnsupported.
  double log10_nfa = 0.0;
  /// E, F: probability that R or t is off by more than 10°, learned on photographs. Above 0.5: kUnreliable. NaN for
  /// other models.
  double error_probability = std::numeric_limits<double>::quiet_NaN();
  Degeneracy degeneracy = Degeneracy::kNotTested;  ///< Two views: what the inliers leave undetermined.
  /// E, absolute poses: share of the fitting points that lie behind a camera. They are no inliers. Above 0.2 (a
  /// mirrored image, say) log10_nfa is infinite.
  double cheirality_failure_ratio = 0.0;
  bool mirrored = false;  ///< Two views: the matches fit the mirror image of the second one; log10_nfa is infinite.
  /// E, unknown focal lengths: the matches contradict K1 and K2, or the prior; both values. The verdict is kUnreliable.
  std::optional<FocalConflict> focal_conflict = {};
  /// Ratios or scores were not used because right matches do not have the better ones, or because only a search without
  /// them found a model.
  bool scores_ignored = false;
  int num_nonfinite = 0;   ///< Rows with a non-finite value, which are dropped.
  int num_duplicates = 0;  ///< Rows that equal another one. Everything but `num_inliers` counts them once.
};

/// One model. Model: a matrix, or the coefficients of a line or plane.
template <class Model>
struct ModelEstimate {
  Status status = Status::kNoModel;    ///< Whether there is a model, or why not.
  Verdict verdict = Verdict::kFailed;  ///< Whether it may be used.
  Model model = Model::Zero();         ///< Zero unless ok().
  std::vector<std::uint8_t> inliers;   ///< N values: 1 for an inlier of `model`, else 0.
  int num_inliers = 0;                 ///< Number of ones in `inliers`, duplicates included.
  double inlier_threshold = 0.0;       ///< Threshold of `inliers`: max_residual, or less if the noise is lower.
  /// Standard deviation of one coordinate of the inliers' residuals, in pixels or the points' unit. E, F and absolute
  /// poses: the noise of an image coordinate; H: √2 times that. NaN if it was not estimated.
  double sigma = 0.0;
  std::vector<float> inlier_probabilities;  ///< N: a network's probabilities before the search; empty without one.
  /// N: probability that each point is right under `model`, by its residual, sigma, the density of outliers and its
  /// ratio or score; 0 without a model.
  std::vector<float> posteriors;
  Diagnostics diagnostics = {};  ///< Why the verdict is what it is.
  EstimationStats stats = {};    ///< Iterations and milliseconds.
  /// Whether there is a model.
  bool ok() const { return status == Status::kOk; }
  /// Whether the verdict is kReliable.
  bool reliable() const { return verdict == Verdict::kReliable; }
};

/// One model with a pose.
template <class Model>
struct PoseEstimate : ModelEstimate<Model> {
  /// Two views: the second camera in the first one's frame, x2 = R x1 + t, |t| = 1, or t = 0 for a camera that only
  /// rotated. Absolute poses: world to camera. Registration: points2 = R points1 + t. Absent if it is not determined.
  std::optional<RigidMotion> pose = {};
  /// Covariance of the pose, 6 × 6 in the order (ω, t): R = exp([ω]ₓ) R̂, ω in radians in the second frame, t in its
  /// unit. E: rank 5, in units of |t|. Similarities: 7 × 7 in the order (ω, t, log s). Absent if the inliers do not
  /// determine the pose, and for unknown focal lengths (docs/estimates.md).
  std::optional<Eigen::MatrixXd> pose_covariance = {};
  /// The second pose of a planar scene, the second motion of a symmetric object, or of two unknown focal lengths the
  /// motion ahead that another zoom makes, if it explains the points nearly as well: it is less than 20 times less
  /// likely.
  std::optional<RigidMotion> ambiguous_pose = {};
};

/// model: x2ᵀ F x1 = 0 in pixels, x2ᵀ E x1 = 0 in coordinates K⁻¹ x, or x2 ~ H x1 in pixels. pose: of E.
struct TwoViewEstimate : PoseEstimate<Eigen::Matrix3d> {
  /// Unknown focal lengths with intervals. If not `observable`, it is the prior's. F: of images of one size, where the
  /// matches allow one camera.
  std::optional<FocalEstimate> focal = {};
};

/// model: x2ᵀ F x1 = 0 in pixels.
struct UnknownFocalEstimate : TwoViewEstimate {
  CameraPair cameras = {};  ///< Calibration matrices with the focal lengths of `focal`.
};

/// model: [R | t], world to camera: u ~ K (R X + t).
struct AbsolutePoseEstimate : PoseEstimate<Eigen::Matrix<double, 3, 4>> {};

/// model: [R | t]: points2 ≈ R points1 + t.
struct RigidMotionEstimate : PoseEstimate<Eigen::Matrix<double, 3, 4>> {};

/// model: [s R | t]: points2 ≈ s R points1 + t. pose: R and t.
struct SimilarityEstimate : PoseEstimate<Eigen::Matrix<double, 3, 4>> {
  double scale = 1.0;  ///< s > 0.
};

using LineEstimate = ModelEstimate<Eigen::Vector3d>;   ///< (a, b, c): a x + b y + c = 0 with a² + b² = 1.
using PlaneEstimate = ModelEstimate<Eigen::Vector4d>;  ///< (a, b, c, d): a x + b y + c z + d = 0, a² + b² + c² = 1.

/// Multiple models of one kind in the same points. Their number is found.
template <class Model>
struct MultiModelEstimate {
  Status status = Status::kNoModel;      ///< kNoModel: no model has more points than chance would give it.
  std::vector<Model> models;             ///< That of most points first.
  std::vector<std::int32_t> assignment;  ///< N values: 0 for an outlier, k for a point of models[k − 1].
  EstimationStats stats = {};            ///< Iterations and milliseconds.
  int num_nonfinite = 0;                 ///< As Diagnostics'.
  int num_duplicates = 0;                ///< As Diagnostics'.
  /// Whether there are models.
  bool ok() const { return status == Status::kOk; }
};

/// The vanishing points of one image, the most probable first (without a network the one of most length), and the
/// camera that they show.
struct VanishingPointsEstimate {
  Status status = Status::kNoModel;         ///< kNoModel: no vanishing point that a person would mark.
  std::vector<Eigen::Vector3d> points;      ///< Homogeneous pixels, of unit length.
  std::vector<Eigen::Vector3d> directions;  ///< As DirectionOf (geometry/vanishing_camera.h); empty if K is unknown.
  /// The network's probability of each, given those before it; empty without a network.
  std::vector<double> values;
  std::vector<std::int32_t> assignment;   ///< N values: 0 for a segment of none, k for one of points[k − 1].
  std::optional<Eigen::Matrix3d> K = {};  ///< The given calibration, or that of `focal`.
  /// If no K is given: estimated from orthogonal vanishing directions. Absent if no two determine it.
  std::optional<VanishingFocal> focal = {};
  /// Absent if no vanishing points show it, or if it depends on an unknown focal length. Without K, `up` is that of a
  /// typical camera.
  std::optional<Horizon> horizon = {};
  EstimationStats stats = {};  ///< Iterations and milliseconds.
  int num_nonfinite = 0;       ///< As Diagnostics'.
  int num_duplicates = 0;      ///< As Diagnostics'.
  /// Whether there are vanishing points.
  bool ok() const { return status == Status::kOk; }
};

}  // namespace diffsac
