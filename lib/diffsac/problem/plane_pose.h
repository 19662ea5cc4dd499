#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "diffsac/geometry/rigid_motion.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// Of motions that are so much likelier than a plane's other one at least 95 % are right (docs/two_view.md).
inline constexpr double kClearOdds = 20.0;

/// How two calibrated cameras that see a plane moved; |t| = 1, or 0 of a pure rotation.
struct PlanePoses {
  RigidMotion pose;
  /// Most planes have two motions.
  std::optional<RigidMotion> other = {};
  double log_odds = std::numeric_limits<double>::infinity();  ///< LogOdds of `pose` against `other`.
  /// Whether the matches do not decide between the two: the odds are below kClearOdds.
  bool ambiguous() const { return other && log_odds < std::log(kClearOdds); }
};

/// Matches of two calibrated images, in pixels, and which of them a model explains to `threshold`.
struct PlaneViews {
  const PointMatrix& points;
  const std::vector<std::uint8_t>& inliers;
  const CameraPair& cameras;
  double threshold = 1.0;
};

/// Of a homography in pixels and its inliers (DecomposeHomography): the motions for which the plane is before the
/// camera where the inliers are, the likelier one first (LogOdds). Nothing of a matrix that is singular or not finite.
std::optional<PlanePoses> PosesOfPlane(const Eigen::Matrix3d& homography, const PlaneViews& views);

/// log of how many times likelier one motion is than another: by the distances of all matches from the epipolar lines
/// of either, once it is refined on them. Outliers have the same density under both. Points off the plane decide, and
/// so does what a plane of no two motions leaves of the noise.
double LogOdds(const RigidMotion& motion, const RigidMotion& other, const PlaneViews& views);

/// The same by the homography of the inliers of another model (FitRobustly), with which a plane is better known than by
/// epipolar geometry.
std::optional<PlanePoses> PosesOfPlane(const PlaneViews& views);

}  // namespace diffsac
