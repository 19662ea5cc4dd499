#pragma once

#include <Eigen/Core>
#include <array>

#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// Motion and plane behind a homography of two calibrated views: K2⁻¹ H K1 ~ R + t nᵀ. The plane is nᵀ X = d in the
/// first camera's frame with |n| = 1 and d > 0; t is in units of d.
struct PlaneMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};

struct PlaneMotions {
  int count = 0;  ///< 4; 1 for a pure rotation (t = 0, n means nothing); 0 for a bad matrix
  std::array<PlaneMotion, 4> motions;
};

/// All motions of a homography in pixels (Faugeras and Lustman 1988, in the form of Ma, Soatto, Košecká and Sastry, "An
/// invitation to 3-D vision", ch. 5.3.3). Both cameras on one side of the plane is assumed (det H > 0 fixes the sign).
/// 0 when H or K is singular or not finite.
PlaneMotions DecomposeHomography(const Eigen::Matrix3d& h, const Eigen::Matrix3d& k1, const Eigen::Matrix3d& k2);

/// Only those motions whose plane lies before the first camera in the direction of every point (pixels, first two
/// columns): nᵀ K1⁻¹ x1 > 0. Mostly two are left.
PlaneMotions KeepVisible(const PlaneMotions& motions, const PointMatrix& points, const Eigen::Matrix3d& k1);

}  // namespace diffsac
