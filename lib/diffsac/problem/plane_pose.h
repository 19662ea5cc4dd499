#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "diffsac/geometry/rigid_motion.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// How two calibrated cameras that see a plane moved; |t| = 1, or 0 of a turn in place.
struct PlanePoses {
  RigidMotion pose;
  /// Most planes have two motions. The other one is here where the matches beside the plane do not decide.
  std::optional<RigidMotion> other = {};
};

/// Matches of two calibrated images, in pixels, and which of them a model explains to `threshold`.
struct PlaneViews {
  const PointMatrix& points;
  const std::vector<std::uint8_t>& inliers;
  const CameraPair& cameras;
  double threshold = 1.0;
};

/// Of a homography in pixels and its inliers (DecomposeHomography): the motions for which the plane is before the
/// camera where the inliers are. Of two the one is `pose` whose epipolar lines more of all matches lie on, and it is
/// alone where chance gives so many more once in twenty times (McNemar 1947). Nothing of a matrix that is singular or
/// not finite.
std::optional<PlanePoses> PosesOfPlane(const Eigen::Matrix3d& homography, const PlaneViews& views);

/// The same by the homography of the inliers of another model (FitRobustly), with which a plane is better known than by
/// epipolar geometry.
std::optional<PlanePoses> PosesOfPlane(const PlaneViews& views);

}  // namespace diffsac
