#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "diffsac/geometry/focal.h"

namespace diffsac {

// What vanishing points of one image say of its camera: of square pixels, without lens distortion. They are homogeneous
// pixels of either sign and any length. `weights`: how sure each of them is, above 0.

/// The direction in space, in the camera's frame (x right, y down, z ahead), of the lines that meet in a vanishing
/// point: a unit vector with z ≥ 0, up where z is 0.
Eigen::Vector3d DirectionOf(const Eigen::Vector3d& point, const Eigen::Matrix3d& K);

/// Focal length of a camera in which orthogonal directions have these two vanishing points: f² = −(a − c)·(b − c), c
/// the principal point (Caprile and Torre, "Using vanishing points for camera calibration", IJCV 1990). Nothing where
/// there is none: one of them at infinity, or both on one side of c.
std::optional<double> FocalOfOrthogonal(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector2d& c);

/// A focal length that vanishing points say.
struct VanishingFocal {
  double focal_px = 0.0;  ///< In pixels.
  /// Standard deviation of its logarithm where each angle between directions is off by kAngleSigmaDeg.
  double log_sigma = 0.0;
  std::vector<int> orthogonal;  ///< The two or three vanishing points whose directions it makes orthogonal, ascending.
};
/// By which angles between directions of vanishing points are off, as found, in degrees: a standard deviation.
inline constexpr double kAngleSigmaDeg = 2.0;
/// A focal length that is less sure is not determined: vanishing points near infinity say nothing of it.
inline constexpr double kMostFocalLogSigma = 0.2;

/// The focal length that makes most of the sure vanishing points orthogonal to each other: of those that two of them
/// say (FocalOfOrthogonal), the one of the greatest sum of the weights of orthogonal pairs, times the prior's density;
/// refined by least squares on the angles of these pairs. Nothing where no two determine it.
std::optional<VanishingFocal> FocalOfVanishingPoints(const std::vector<Eigen::Vector3d>& points,
                                                     const std::vector<double>& weights, const Eigen::Vector2d& c,
                                                     const FocalPrior& prior);

/// Where the horizon is: the image of all horizontal directions.
struct Horizon {
  Eigen::Vector3d line = Eigen::Vector3d::Zero();  ///< (a, b, c): a x + b y + c = 0 in pixels, a² + b² = 1, b > 0.
  Eigen::Vector3d up = Eigen::Vector3d::Zero();    ///< The upward direction in the camera's frame, |up| = 1.
  int vertical = -1;                               ///< The vanishing point of vertical lines, −1 where there is none.
  std::vector<int> horizontal;                     ///< Those of horizontal lines, ascending.
  /// Where it is in a column of the image, in pixels.
  double RowAt(double x) const { return -(line[0] * x + line[2]) / line[1]; }
  /// By how much it falls to the right, in degrees.
  double TiltDeg() const;
  /// How far the camera looks up, in degrees.
  double PitchDeg() const;
};

/// The horizon of a camera that is held upright, tilted and pitched by less than 45°: from the surest vanishing point
/// that may be vertical and from those orthogonal to it, by least squares; without a vertical one from the two surest
/// whose plane may be level. Nothing where there is neither.
std::optional<Horizon> HorizonOf(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& weights,
                                 const Eigen::Matrix3d& K);

}  // namespace diffsac
