#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/model.h"

namespace diffsac {

/// The pose of a calibrated camera in a known scene: u ~ R X + t. Points are X Y Z u v, a point of the scene, in its
/// unit, and its image in normalised coordinates (K⁻¹ times pixels); parameters are [R | t], 3 × 4, row-major. Minimal
/// sets of 3 points (P3P).
struct AbsolutePose {
  using Parameters = Eigen::Matrix<double, 12, 1>;
  static constexpr int kDimension = 5;
  static constexpr int kResidualDimension = 2;  ///< Of what `Residual` is the length of.
  static constexpr int kMinimalSize = 3;
  static constexpr int kMaxSolutions = 4;
  /// Of a reprojection error, for MAGSAC++.
  static constexpr int kResidualDof = 2;

  /// Poses with all three points before the camera (SolveP3P).
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out);

  /// The pose of least weighted squared reprojection errors: Levenberg-Marquardt from a direct linear transformation
  /// (Hartley and Zisserman, ch. 7.1), or from the homography of the plane nearest to the points where that is closer.
  /// Needs 4 points of positive weight, not on one line; fewer than 6 only where they are near a plane.
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out);

  /// Finite, and neither the points of the scene nor their images all on one line.
  static bool Determined(const PointMatrix& points);

  /// Reprojection error in the image, linear, in normalised coordinates (a threshold in pixels divided by the focal
  /// length); infinite for a point that is not before the camera.
  static double Residual(const Parameters& model, const double* point);

  /// As `Residual`, over 5 columns.
  static void Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out);

  /// Levenberg-Marquardt on SE(3) with the loss truncated at `threshold` (in the unit of `Residual`) on all points.
  /// False, leaving *model, when that does not lower the cost or the points are unfit.
  static bool Refine(const PointMatrix& points, double threshold, Parameters* model);

  /// A plane seen from afar looks the same when its normal is mirrored at the line of sight: the loss truncated at
  /// `threshold` has two minima (Schweighofer and Pinz, "Robust pose estimation from a planar target", PAMI 2006;
  /// Collins and Bartoli, "Infinitesimal plane-based pose estimation", IJCV 2014). Makes *model the better of the two;
  /// true where the other one, then *other, is less than kOddsToTell times less likely. False where the inliers' relief
  /// would be seen, and where there is one minimum. Adds its fits to *fits.
  static bool OtherMinimum(const PointMatrix& points, double threshold, Parameters* model, Parameters* other,
                           int* fits);
  static constexpr double kOddsToTell = 20.0;
};

/// The rotation and translation of a pose and back.
Eigen::Matrix3d RotationOf(const AbsolutePose::Parameters& model);
Eigen::Vector3d TranslationOf(const AbsolutePose::Parameters& model);
AbsolutePose::Parameters PoseOf(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation);

/// Σ weight JᵀJ of the reprojections of points before the camera by (ω, δ): R ← exp([ω]ₓ) R, t ← t + δ.
Eigen::Matrix<double, 6, 6> ReprojectionInformation(const PointMatrix& points, const Eigen::VectorXd& weights,
                                                    const AbsolutePose::Parameters& pose);

/// All real poses of three points before the camera, at most 4; 0 when they are on one line.
///
/// Ding, Yang, Larsson, Olsson, Åström, "Revisiting the P3P problem", CVPR 2023: the law of cosines for the three pairs
/// of rays gives two conics in the ratios of the depths. One degenerate conic of their pencil, from a real root of a
/// cubic, is two lines, whose intersections with the other conic are the solutions. Depths are polished by Newton steps
/// on the three distances, since the elimination loses digits near degenerate sets.
int SolveP3P(const Eigen::Vector3d scene[3], const Eigen::Vector3d rays[3], AbsolutePose::Parameters out[4]);

}  // namespace diffsac
