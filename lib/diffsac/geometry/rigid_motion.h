#pragma once

#include <Eigen/Core>

namespace diffsac {

/// A world-to-camera or camera-to-camera motion, with its unit of length: x' = rotation · x + translation.
struct RigidMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();   ///< t, in the motion's unit.
  /// Every number is equal.
  bool operator==(const RigidMotion&) const = default;
};

/// From camera 1 to camera 2, both given world-to-camera: R = R2 R1ᵀ, t = T2 − R T1.
RigidMotion RelativeMotion(const RigidMotion& camera1, const RigidMotion& camera2);

/// The inverse motion: camera-to-world from world-to-camera and back.
RigidMotion Inverse(const RigidMotion& motion);

}  // namespace diffsac
