#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/core/version.h"
#include "diffsac/estimators/estimator.h"
#include "diffsac/estimators/robust_estimator.h"
#include "diffsac/geometry/rigid_motion.h"
#include "diffsac/geometry/vanishing_camera.h"
#include "diffsac/problem/image_pair.h"
#include "diffsac/problem/problem.h"

/// Robust estimation of geometric models from points that are only partly right. One function a problem:
///
/// ```
/// diffsac::Matches matches;                                   // points1, points2: N × 2, in pixels
/// matches.match_ratios = ratios;                              // not needed, but they help most
/// const auto estimate = diffsac::EstimateEssential(matches, {K1, K2});
/// if (estimate.ok() && !estimate.may_be_chance()) Use(estimate.pose->rotation, estimate.inliers);
/// ```
///
/// Use it when a share of the points is wrong: matches between images, scans, 2D-3D correspondences. The defaults are
/// what we recommend (docs/two_view.md says what each part is worth); with a network where one helps, which comes with
/// the library. When nothing is wrong, fit by least squares; when you want another search, its options are plain
/// structs (estimators/presets.h), and RobustEstimator is the interface of all.
///
/// What a function needs besides points (a network, checked options, memory) is made at the first call and kept by the
/// options that make it, so that a call costs no more than its estimate. An Estimator (estimators/estimator.h) is the
/// same to hold yourself: made before the first problem comes, and for problems that are put together by hand.
///
/// Needs Eigen and TBB alone. Functions may be called from any number of threads. The same input, options and seed give
/// the same result. Bad data is never an exception: the result's status says what was wrong. Options that make no
/// sense, matrices K that are no calibration, ratios or scores outside [0, 1], inputs of unlike lengths and models that
/// are not found throw diffsac::Error, whose text says what was expected.
///
/// Rows with a value that is not finite are left out. Rows that are equal are one point, with the best of their ratios
/// or scores, for all that is found and said. Masks and assignments have all N rows all the same.
namespace diffsac {

/// Of images.
struct ImageOptions : EstimateOptions {
  /// The greatest residual of an inlier, in pixels or whatever the points are in (E and F: Sampson error; H: transfer
  /// error; poses: reprojection error). 0: 1 px, homographies 3, absolute poses 4; where the median point is not 20 to
  /// 20000 from the origin, as of coordinates from 0 to 1, normalised ones or large film, a thousandth of how far the
  /// points go stands for a pixel. E, F and H look for the noise themselves, of thresholds from the value given (F half
  /// of it, H two thirds) to 4 times it (H: 8/3). A value above those thousandths (H: three times these) looks from
  /// there on, for noise may be far below it; one below a fifth of them looks to where a fifth would. So nothing but
  /// the unit of the results changes where points, calibration and this are in another unit.
  double max_residual_px = 0.0;
  /// Throws Error naming the field and what was expected.
  void Check() const;
};

/// Of points in the plane or in space.
struct PointOptions : EstimateOptions {
  /// The greatest distance of an inlier, in the points' unit. There is no good default: it must be given.
  double max_distance = 0.0;
  PointOptions() = default;
  /// `max_distance`.
  explicit PointOptions(double max_distance_value) : max_distance(max_distance_value) {}
  /// Throws Error naming the field and what was expected.
  void Check() const;
};

/// Of matches of two clouds.
struct CloudOptions : EstimateOptions {
  /// The greatest distance of an inlier, in the second cloud's unit. Noise is looked for from a quarter of it to half
  /// as much again. 0: twice the resolution of the second cloud's matched points (the median distance of their places
  /// to the nearest other one; many matches that end in one place are one), which is what clouds that were thinned out
  /// to that resolution need; where few points are matched, give it.
  double max_distance = 0.0;
  CloudOptions() = default;
  /// `max_distance`.
  explicit CloudOptions(double max_distance_value) : max_distance(max_distance_value) {}
  /// Throws Error naming the field and what was expected.
  void Check() const;
};

/// Of images of unknown focal length.
struct FocalOptions : ImageOptions {
  /// Of the first image in pixels; absent: its centre, for which Matches has the size.
  std::optional<Eigen::Vector2d> principal_point1 = {};
  std::optional<Eigen::Vector2d> principal_point2 = {};  ///< Of the second image.
  /// The likeliest focal length in pixels and how sure it is (EXIF's, say, with .1); absent: that of cameras in
  /// general, for which Matches has the sizes.
  std::optional<FocalPrior> prior = {};
  std::optional<FocalPrior> prior2 = {};  ///< EstimateTwoFocals: of the second image; absent: as `prior`.
  /// Throws Error naming the field and what was expected.
  void Check() const;
};

/// Matches of two images.
struct Matches {
  Eigen::Matrix<double, Eigen::Dynamic, 2> points1;  ///< N × 2, in pixels.
  Eigen::Matrix<double, Eigen::Dynamic, 2> points2;  ///< N × 2, in pixels; row i matches row i of `points1`.
  Eigen::VectorXd match_ratios = {};  ///< N: nearest to second-nearest descriptor distance, from 0 to 1, lower is
                                      ///< better; empty: unknown.
  ImageSize size1 = {};               ///< In pixels; {}: unknown. It helps F. Error: 15 % of points1 are outside.
  ImageSize size2 = {};               ///< As `size1`.
  /// N × 2: the logarithm of size2 / size1 of the keypoints and angle2 − angle1 in radians (OpenCV's KeyPoint::size,
  /// and KeyPoint::angle · π / 180); empty: unknown. Essential and fundamental matrices gain by them: networks read
  /// them, and a match whose keypoints do not turn as its epipolar lines do counts less.
  Eigen::Matrix<double, Eigen::Dynamic, 2> similarities = {};
  /// N: instead of ratios, what a matcher says of each match, from 0 to 1, higher is better (LightGlue's and the like);
  /// empty: unknown. Give all matches: a cut by score (LightGlue's filter_threshold) loses more than it helps. No
  /// network is used with scores.
  Eigen::VectorXd scores = {};
};

/// Points of a scene and where an image shows them.
struct ScenePoints {
  Eigen::Matrix<double, Eigen::Dynamic, 3> points3d;  ///< N × 3, in the scene's unit.
  Eigen::Matrix<double, Eigen::Dynamic, 2> points2d;  ///< N × 2, in pixels.
  Eigen::VectorXd match_ratios = {};                  ///< As Matches::match_ratios.
  Eigen::VectorXd scores = {};                        ///< As Matches::scores.
};

/// Matches of two clouds.
struct CloudMatches {
  Eigen::Matrix<double, Eigen::Dynamic, 3> points1;  ///< N × 3, in the first cloud's unit.
  Eigen::Matrix<double, Eigen::Dynamic, 3> points2;  ///< N × 3; row i matches row i of `points1`.
  Eigen::VectorXd match_ratios = {};                 ///< As Matches::match_ratios: the order of the draws.
  Eigen::VectorXd scores = {};                       ///< As Matches::scores: the same.
};

/// A result. Model: a matrix, or the coefficients of a line or plane.
template <class Model>
struct ModelEstimate {
  Status status = Status::kNoModel;   ///< Whether there is a model, or why not.
  Model model = Model::Zero();        ///< Zero unless status is kOk.
  std::vector<std::uint8_t> inliers;  ///< N values, 1 for an inlier of `model`; all 0 without one.
  int num_inliers = 0;                ///< Of `inliers`, repeated rows included.
  double inlier_threshold = 0.0;      ///< Of these: what was asked for, or less where the noise was found to be less.
  /// σ of the noise, in pixels or the points' unit: of one coordinate of the inliers' residuals. For E, F and absolute
  /// poses it is that of each image coordinate, for H √2 times it where both images' points are as noisy. Any value
  /// from 0; about the threshold that was looked at where it is that or more. NaN where it is not estimated.
  double noise_scale = 0.0;
  /// log10 of the number of models with as many inliers that chance would give.
  double log_false_alarms = 0.0;
  /// N values, how likely each point is an inlier as the network said before the search; empty without a network.
  std::vector<float> inlier_probabilities;
  /// N values, how likely each point is right under `model`: by its residual, the noise, how crowded residuals are that
  /// are just no inliers', and its score or ratio, which need not be a probability itself; 0 without a model.
  std::vector<float> posteriors;
  EstimateReport cost;    ///< Hypotheses, milliseconds.
  int rows_left_out = 0;  ///< That have a value that is not finite.
  int repeated_rows = 0;  ///< That equal another one: `log_false_alarms` and all else but `num_inliers` count it once.
  /// Whether the matches' ratios or scores were not used, because they are worse than none: right matches are not the
  /// better scored (costs passed as scores, say), or a search without them found what one with them did not.
  bool scores_ignored = false;
  /// Whether there is a model.
  bool ok() const { return status == Status::kOk; }
  /// Whether points without any model would give one like this: better not relied upon.
  bool may_be_chance() const { return log_false_alarms > 0.0; }
};

/// Of two views: x2ᵀ F x1 = 0 in pixels, x2ᵀ E x1 = 0 in coordinates K⁻¹ x, x2 ~ H x1 in pixels.
struct TwoViewEstimate : ModelEstimate<Eigen::Matrix3d> {
  /// E, and F with cameras given: the second camera seen from the first, |t| = 1, chosen by cheirality. t = 0 where the
  /// camera turned in place or stood still (`translation`); absent where a line leaves the motion open.
  std::optional<RigidMotion> pose = {};
  /// Of matches that lie on one plane, which mostly two motions explain: the other one. There is no pose_covariance
  /// then.
  std::optional<RigidMotion> other_pose = {};
  /// E: of the pose, 6 × 6 in the order (ω, t): R = exp([ω]ₓ) R̂, ω in radians in the second camera's frame, t in units
  /// of its length, orthogonal to it: rank 5. Absent where the inliers do not determine the pose.
  std::optional<Eigen::MatrixXd> pose_covariance = {};
  /// Whether the inliers determine the translation, or, of F and H, the model: kDetermined, or why not. A camera that
  /// only turned is no failure: R is right, and `model` is one of those that explain the matches.
  Translation translation = Translation::kNotTested;
  /// Whether the matches fit the mirror image of the second photograph; this result may be chance then.
  bool mirrored = false;
  /// E and F: how likely R or t is off by more than 10°, as learned on photographs (estimators/error_probability.h);
  /// NaN for others.
  double error_probability = std::numeric_limits<double>::quiet_NaN();
  /// E and unknown focal lengths: where the matches contradict the focal lengths of K1 and K2, or the prior, what
  /// either says. There is no pose_covariance, and no focal length is observable, then.
  std::optional<FocalConflict> focal_conflict = {};
  /// Whether results like this are wrong too often to rely on.
  bool may_be_wrong() const { return may_be_chance() || error_probability > kLikelyWrong || focal_conflict; }
  /// E: of the matches that fit, the share that lies behind a camera. They are no inliers. Where it is beyond
  /// kMostBehind (an image is mirrored, say) the result may be chance.
  double share_behind = 0.0;
};
/// Of two views of unknown focal length. model: x2ᵀ F x1 = 0 in pixels. There is no pose_covariance: none that is told
/// from the matches alone holds the truth as often as it says (docs/estimates.md).
struct SharedFocalEstimate : TwoViewEstimate {
  /// With their intervals; one that is not `observable` is the prior's.
  std::optional<FocalEstimate> focal = {};
  CameraPair cameras = {};  ///< Of these focal lengths.
};
/// model: [R | t], world-to-camera, u ~ K (R X + t).
struct AbsolutePoseEstimate : ModelEstimate<Eigen::Matrix<double, 3, 4>> {
  RigidMotion pose = {};  ///< The same; identity unless status is kOk.
  /// As TwoViewEstimate's, ω in the camera's frame, t in the scene's unit.
  std::optional<Eigen::MatrixXd> pose_covariance = {};
  double share_behind = 0.0;  ///< As TwoViewEstimate's.
  /// Of a plane, seen from afar or badly, where the points do not say which of two poses is right: the other one, that
  /// is less than 20 times less likely. There is no pose_covariance then.
  std::optional<RigidMotion> other_pose = {};
  /// Whether there is `other_pose`.
  bool ambiguous() const { return other_pose.has_value(); }
};
/// model: [R | t], points2 ≈ R points1 + t.
struct RigidMotionEstimate : ModelEstimate<Eigen::Matrix<double, 3, 4>> {
  RigidMotion motion = {};  ///< The same; identity unless status is kOk.
  /// 6 × 6 in the order (ω, t): R = exp([ω]ₓ) R̂, ω in radians in the second cloud's frame, t, that of `motion`, in its
  /// unit. Absent where the inliers do not determine the motion.
  std::optional<Eigen::MatrixXd> covariance = {};
  /// Of a symmetric thing: another motion, which explains other matches and hardly fewer (by no more than 1.645 √n of
  /// the n that one of the two alone explains). There is no covariance then.
  std::optional<RigidMotion> other_motion = {};
  /// Whether there is `other_motion`.
  bool ambiguous() const { return other_motion.has_value(); }
};
/// model: [s R | t], points2 ≈ s R points1 + t with s > 0.
struct SimilarityEstimate : ModelEstimate<Eigen::Matrix<double, 3, 4>> {
  double scale = 1.0;       ///< s.
  RigidMotion motion = {};  ///< R and t; identity unless status is kOk.
  /// 7 × 7 in the order (ω, t, log s), else as RigidMotionEstimate's.
  std::optional<Eigen::MatrixXd> covariance = {};
};
/// (a, b, c): a x + b y + c = 0 with a² + b² = 1.
using LineEstimate = ModelEstimate<Eigen::Vector3d>;
/// (a, b, c, d): a x + b y + c z + d = 0 with a² + b² + c² = 1.
using PlaneEstimate = ModelEstimate<Eigen::Vector4d>;

/// A fundamental matrix. Draws by a network and PROSAC.
TwoViewEstimate EstimateFundamental(const Matches& matches, const ImageOptions& options = {});
/// An essential matrix and the pose. Draws by a network and PROSAC. cameras: calibration matrices K1 and K2 (here and
/// below fx s cx, 0 fy cy, 0 0 1 with fx and fy above 0, or times a number above 0), without lens distortion.
TwoViewEstimate EstimateEssential(const Matches& matches, const CameraPair& cameras, const ImageOptions& options = {});
/// Both images are of one camera of unknown focal length. Draws by PROSAC; there is no network.
SharedFocalEstimate EstimateSharedFocal(const Matches& matches, const FocalOptions& options = {});
/// The first camera is calibrated, the focal length of the second is unknown: `options` are of the second image.
SharedFocalEstimate EstimateOneFocal(const Matches& matches, const Eigen::Matrix3d& K1,
                                     const FocalOptions& options = {});
/// Each image is of a camera of its own, of unknown focal length: photographs from anywhere. Draws by PROSAC; there is
/// no network.
SharedFocalEstimate EstimateTwoFocals(const Matches& matches, const FocalOptions& options = {});
/// A homography. Draws by a network and PROSAC.
TwoViewEstimate EstimateHomography(const Matches& matches, const ImageOptions& options = {});
/// The pose of an image whose calibration is K, without lens distortion. Draws by PROSAC where there are ratios.
AbsolutePoseEstimate EstimateAbsolutePose(const ScenePoints& points, const Eigen::Matrix3d& K,
                                          const ImageOptions& options = {});
/// The motion from one cloud to another. Draws matches whose edges are of equal length in both, by ratio where there
/// are ratios (docs/registration.md).
RigidMotionEstimate EstimateRigidMotion(const CloudMatches& matches, const CloudOptions& options = {});
/// The same with a scale, as between two reconstructions.
SimilarityEstimate EstimateSimilarity(const CloudMatches& matches, const CloudOptions& options = {});
/// points: N × 2.
LineEstimate EstimateLine(const Eigen::Matrix<double, Eigen::Dynamic, 2>& points, const PointOptions& options);
/// points: N × 3.
PlaneEstimate EstimatePlane(const Eigen::Matrix<double, Eigen::Dynamic, 3>& points, const PointOptions& options);

/// Several models of one kind in the same points, found without being told how many.
template <class Model>
struct ModelsEstimate {
  Status status = Status::kNoModel;  ///< kNoModel: nothing that chance would not give.
  std::vector<Model> models;         ///< That of most points first.
  /// N values: 0 for a point of none, k for one of models[k − 1].
  std::vector<std::int32_t> assignment;
  EstimateReport cost;    ///< Hypotheses, milliseconds.
  int rows_left_out = 0;  ///< As ModelEstimate's.
  int repeated_rows = 0;  ///< As ModelEstimate's.
  /// Whether there are models.
  bool ok() const { return status == Status::kOk; }
};

/// Several fundamental matrices. Here and below samples are drawn from neighbouring points, and no network is used
/// (docs/several.md).
ModelsEstimate<Eigen::Matrix3d> EstimateFundamentals(const Matches& matches, const ImageOptions& options = {});
/// Several essential matrices.
ModelsEstimate<Eigen::Matrix3d> EstimateEssentials(const Matches& matches, const CameraPair& cameras,
                                                   const ImageOptions& options = {});
/// Several homographies.
ModelsEstimate<Eigen::Matrix3d> EstimateHomographies(const Matches& matches, const ImageOptions& options = {});
/// Several poses: things that move by themselves.
ModelsEstimate<Eigen::Matrix<double, 3, 4>> EstimateAbsolutePoses(const ScenePoints& points, const Eigen::Matrix3d& K,
                                                                  const ImageOptions& options = {});
/// Several motions between two clouds: things that move by themselves. Draws as EstimateRigidMotion.
ModelsEstimate<Eigen::Matrix<double, 3, 4>> EstimateRigidMotions(const CloudMatches& matches,
                                                                 const CloudOptions& options = {});
/// Several lines.
ModelsEstimate<Eigen::Vector3d> EstimateLines(const Eigen::Matrix<double, Eigen::Dynamic, 2>& points,
                                              const PointOptions& options);
/// Several planes.
ModelsEstimate<Eigen::Vector4d> EstimatePlanes(const Eigen::Matrix<double, Eigen::Dynamic, 3>& points,
                                               const PointOptions& options);

/// Of vanishing points.
struct VanishingPointOptions : EstimateOptions {
  /// The image's calibration, without lens distortion. Absent: of unknown focal length about the image's middle.
  std::optional<Eigen::Matrix3d> K = {};
  ImageSize size = {};  ///< Of the image, in pixels; needed where K is absent.
  /// A segment is of a vanishing point that it points at within this angle.
  double max_residual_deg = 2.0;
  /// The list ends before the first of which the network is less sure than this, in [0, 1]; 0: eight.
  double least_value = 0.35;
  /// Throws Error naming the field and what was expected.
  void Check() const;
};

/// The vanishing points of one image, the surest first (without a network that of most length), and what they say of
/// its camera.
struct VanishingPointsEstimate {
  Status status = Status::kNoModel;         ///< kNoModel: nothing that a person would call one.
  std::vector<Eigen::Vector3d> points;      ///< Homogeneous pixels, of unit length.
  std::vector<Eigen::Vector3d> directions;  ///< As DirectionOf has them; empty where K is unknown.
  /// How sure the network is of each beside those before it, in [0, 1]; empty without a network.
  std::vector<double> values;
  /// N values: 0 for a segment of none, k for one of points[k − 1].
  std::vector<std::int32_t> assignment;
  std::optional<Eigen::Matrix3d> K = {};  ///< That was given, or of `focal`.
  /// Where no K was given: found from orthogonal directions. Absent where no two vanishing points determine it.
  std::optional<VanishingFocal> focal = {};
  /// Absent where no vanishing points show it, or where it depends on a focal length that is unknown. Without K its
  /// `up` is that of a usual camera.
  std::optional<Horizon> horizon = {};
  EstimateReport cost;    ///< Hypotheses, milliseconds.
  int rows_left_out = 0;  ///< As ModelEstimate's.
  int repeated_rows = 0;  ///< As ModelEstimate's.
  /// Whether there are vanishing points.
  bool ok() const { return status == Status::kOk; }
};

/// Vanishing points of an image's line segments, N × 4: x1 y1 x2 y2, the ends, in pixels. Long ones count more. Chosen
/// by a network that learned from people's labels (docs/vanishing_points.md).
VanishingPointsEstimate EstimateVanishingPoints(const Eigen::Matrix<double, Eigen::Dynamic, 4>& segments,
                                                const VanishingPointOptions& options);

/// Models are looked for in this folder as well, after the others.
void AddModelsFolder(const std::string& folder);

#ifdef DIFFSAC_INSTALLED_MODELS
namespace internal {
// find_package(diffsac) knows where the models were installed.
inline const bool kInstalledModelsAdded = (AddModelsFolder(DIFFSAC_INSTALLED_MODELS), true);
}  // namespace internal
#endif

}  // namespace diffsac
