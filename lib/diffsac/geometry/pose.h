#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// The second camera seen from the first: X2 = R X1 + t. From E alone t has unit length (its size is not observable).
struct RelativePose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R.
  Eigen::Vector3d translation = Eigen::Vector3d::UnitX();  ///< t.
};

/// [t]ₓ R, with t at its own length.
Eigen::Matrix3d EssentialFromPose(const RelativePose& pose);
/// K2ᵀ F K1; an essential matrix up to the error of F (ClosestEssential projects it).
Eigen::Matrix3d EssentialFromFundamental(const Eigen::Matrix3d& f, const Eigen::Matrix3d& k1,
                                         const Eigen::Matrix3d& k2);
/// K2⁻ᵀ E K1⁻¹.
Eigen::Matrix3d FundamentalFromEssential(const Eigen::Matrix3d& e, const Eigen::Matrix3d& k1,
                                         const Eigen::Matrix3d& k2);

/// Correspondences in pixels to normalised coordinates, K⁻¹ (x, y, 1) in each image.
PointMatrix NormalizedCoordinates(const PointMatrix& pixels, const Eigen::Matrix3d& k1, const Eigen::Matrix3d& k2);

/// The four poses of an essential matrix: (R, ±t) and the twisted pair (Hartley and Zisserman, result 9.19). Not finite
/// for a matrix that is not finite.
std::array<RelativePose, 4> DecomposeEssential(const Eigen::Matrix3d& e);

/// Whether the point where the two rays come closest lies before both cameras.
bool InFront(const RelativePose& pose, const double* point);

/// The same, or it would with images up to `tolerance` (in normalised coordinates) elsewhere: far points, whose rays
/// are parallel, and points near an epipole come out before or behind by noise alone.
bool PassesCheirality(const RelativePose& pose, const double* point, double tolerance);

/// The pose chosen from the four of an essential matrix.
struct PoseChoice {
  /// kOk; kTooFewPoints: no point is given; kNoModel: no point lies before both cameras of any pose;
  /// kDegenerate: something is not finite, or two poses have equally many points in front (the first is returned).
  Status status = Status::kNoModel;
  RelativePose pose;  ///< That of most points in front.
  int in_front = 0;   ///< points before both cameras of the returned pose
  int runner_up = 0;  ///< and of the second best
};

/// Chooses among the four poses by how many of the points (normalised coordinates, rows with inliers[i] != 0; empty:
/// all) lie before both cameras. noise, where it is above 0, is what images may be off: then the sign of t is chosen by
/// the points with their squared parallax, up to twice the noise. Far ones may all come out on the wrong side, by the
/// rotation's own error.
PoseChoice ChoosePose(const Eigen::Matrix3d& e, const PointMatrix& points,
                      const std::vector<std::uint8_t>& inliers = {}, double noise = 0.0);

/// Angle of R1ᵀ R2 in degrees, [0, 180]; exact near 0 and near 180.
double RotationAngleDegrees(const Eigen::Matrix3d& r1, const Eigen::Matrix3d& r2);
/// Angle of two vectors in degrees, [0, 180]; NaN for a zero vector.
double DirectionAngleDegrees(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// The mean of the four focal lengths: pixels in one unit of normalised coordinates.
inline double MeanFocal(const Eigen::Matrix3d& K1, const Eigen::Matrix3d& K2) {
  return (K1(0, 0) + K1(1, 1) + K2(0, 0) + K2(1, 1)) / 4.0;
}

}  // namespace diffsac
