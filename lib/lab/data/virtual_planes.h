#pragma once

#include <Eigen/Core>
#include <optional>

#include "diffsac/core/options.h"
#include "lab/data/virtual_views.h"

namespace diffsac {

/// Points nearer than this (in a scene's unit, its nearest depth) are not seen.
inline constexpr double kLeastDepth = 0.1;

/// The plane normal · X = distance with distance > 0 in the first camera's coordinates.
struct VirtualPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance = 1.0;

  /// x2 ~ H x1 in pixels.
  Eigen::Matrix3d Homography(const VirtualPair& pair) const;
  /// Whether camera 2 is on the same side of the plane as camera 1, and not too near.
  bool FacesBoth(const RigidMotion& motion) const;
  /// The exact correspondence of the plane's point that `pixel` of image 1 shows. False unless ProjectIntoBoth, and
  /// where its depth is less than half of the nearest or more than twice the farthest of `depths`.
  bool Match(const VirtualPair& pair, const Range& depths, const Eigen::Vector2d& pixel, Eigen::Vector4d* match) const;
};

/// The motion to a second camera at `centre2`. It is turned by `turn` after it was turned towards the point of the
/// first camera's axis at depth `towards`, where that is given.
RigidMotion MotionTo(const Eigen::Vector3d& centre2, const Eigen::Matrix3d& turn, std::optional<double> towards);

}  // namespace diffsac
