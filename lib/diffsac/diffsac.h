#pragma once

#include <Eigen/Core>
#include <string>

#include "diffsac/core/status.h"
#include "diffsac/core/version.h"
#include "diffsac/correspondences.h"
#include "diffsac/options.h"
#include "diffsac/results.h"

/// Robust estimation of geometric models in the presence of outliers: one function for each problem.
///
/// ```
/// const auto estimate = diffsac::EstimateEssential({.points1 = x1, .points2 = x2, .snn_ratio = ratios}, {K1, K2},
///                                                  {.confidence = 0.9999, .seed = 7});   // x1, x2: N × 2, in pixels
/// if (estimate.verdict == diffsac::Verdict::kReliable) Use(estimate.pose->rotation, estimate.inliers);
/// ```
///
/// Guidance: by default E, F and H sample by a small network and PROSAC together (Guidance::kNetwork). It is the
/// default because it finds more poses than PROSAC where few matches are right, and as many as the diffusion process of
/// the paper (Guidance::kDiffusion) in a fraction of its time (docs/two_view.md). Guidance::kNone is PROSAC alone.
///
/// Inputs are views of the caller's memory, which must live as long as the call. Non-finite rows are dropped. Exact
/// duplicates are merged and keep the best ratio or score. Masks and assignments have all N rows.
///
/// Returns a status for bad data. Throws diffsac::Error, a std::invalid_argument, for options out of range, matrices K
/// that are no calibration, ratios or scores outside [0, 1] and inputs of unequal lengths; its text names the argument.
///
/// Depends on Eigen and TBB. Functions may be called from any thread. The same input, options and seed give the same
/// result. A first call makes what later ones share; an Estimator (estimate/estimator.h) holds the same explicitly.
namespace diffsac {

/// Fundamental matrix.
TwoViewEstimate EstimateFundamental(const Matches& matches, const ImageOptions& options = {});
/// Essential matrix and relative pose. cameras: calibration matrices K1 and K2 (here and below [fx s cx; 0 fy cy; 0 0
/// 1] with fx, fy > 0, up to a positive factor), without lens distortion.
TwoViewEstimate EstimateEssential(const Matches& matches, const CameraPair& cameras, const ImageOptions& options = {});
/// Homography.
TwoViewEstimate EstimateHomography(const Matches& matches, const ImageOptions& options = {});
/// The same with the relative pose of calibrated cameras that see a plane or only turned. cameras: as
/// EstimateEssential's.
TwoViewEstimate EstimateCalibratedHomography(const Matches& matches, const CameraPair& cameras,
                                             const ImageOptions& options = {});

/// Fundamental matrix, focal length and pose of two images of one camera. Here and in the next two functions the focal
/// length is unknown and no network is used.
UnknownFocalEstimate EstimateSharedFocal(const Matches& matches, const FocalOptions& options = {});
/// The same if the first camera is calibrated and the focal length of the second is unknown. `options` are those of the
/// second image.
UnknownFocalEstimate EstimateOneFocal(const Matches& matches, const Eigen::Matrix3d& K1,
                                      const FocalOptions& options = {});
/// The same if each image has a camera of its own: photographs from anywhere.
UnknownFocalEstimate EstimateTwoFocals(const Matches& matches, const FocalOptions& options = {});

/// Pose of an image with calibration matrix K, without lens distortion.
AbsolutePoseEstimate EstimateAbsolutePose(const Matches2D3D& matches, const Eigen::Matrix3d& K,
                                          const ImageOptions& options = {});

/// Rigid motion from one cloud to another. Samples matches whose distances agree in both clouds (docs/registration.md).
RigidMotionEstimate EstimateRigidMotion(const Matches3D3D& matches, const RegistrationOptions& options = {});
/// The same with a scale, as between two reconstructions.
SimilarityEstimate EstimateSimilarity(const Matches3D3D& matches, const RegistrationOptions& options = {});

/// Line. points: N × 2.
LineEstimate EstimateLine(const Points2DView& points, const PointOptions& options);
/// Plane. points: N × 3.
PlaneEstimate EstimatePlane(const Points3DView& points, const PointOptions& options);

/// Vanishing points of the line segments of an image, with its focal length and horizon. segments: N × 4: x1 y1 x2 y2,
/// the ends, in pixels. Long segments count more. A network chooses among sampled ones (docs/vanishing_points.md).
VanishingPointsEstimate EstimateVanishingPoints(const SegmentsView& segments, const VanishingPointOptions& options);

/// Multiple fundamental matrices in the same matches. Here and below samples are drawn from neighbouring points and no
/// network is used (docs/several.md).
MultiModelEstimate<Eigen::Matrix3d> EstimateMultipleFundamentals(const Matches& matches,
                                                                 const ImageOptions& options = {});
/// Multiple essential matrices.
MultiModelEstimate<Eigen::Matrix3d> EstimateMultipleEssentials(const Matches& matches, const CameraPair& cameras,
                                                               const ImageOptions& options = {});
/// Multiple homographies.
MultiModelEstimate<Eigen::Matrix3d> EstimateMultipleHomographies(const Matches& matches,
                                                                 const ImageOptions& options = {});
/// Multiple poses: objects that move independently.
MultiModelEstimate<Eigen::Matrix<double, 3, 4>> EstimateMultipleAbsolutePoses(const Matches2D3D& matches,
                                                                              const Eigen::Matrix3d& K,
                                                                              const ImageOptions& options = {});
/// Multiple rigid motions between two clouds: objects that move independently. Samples as EstimateRigidMotion.
MultiModelEstimate<Eigen::Matrix<double, 3, 4>> EstimateMultipleRigidMotions(const Matches3D3D& matches,
                                                                             const RegistrationOptions& options = {});
/// Multiple lines. points: N × 2.
MultiModelEstimate<Eigen::Vector3d> EstimateMultipleLines(const Points2DView& points, const PointOptions& options);
/// Multiple planes. points: N × 3.
MultiModelEstimate<Eigen::Vector4d> EstimateMultiplePlanes(const Points3DView& points, const PointOptions& options);

}  // namespace diffsac

#include "diffsac/deprecated_0_2.h"
