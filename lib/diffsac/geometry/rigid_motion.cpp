#include "diffsac/geometry/rigid_motion.h"

namespace diffsac {

RigidMotion RelativeMotion(const RigidMotion& camera1, const RigidMotion& camera2) {
  RigidMotion relative;
  relative.rotation = camera2.rotation * camera1.rotation.transpose();
  relative.translation = camera2.translation - relative.rotation * camera1.translation;
  return relative;
}

RigidMotion Inverse(const RigidMotion& motion) {
  return {motion.rotation.transpose(), -(motion.rotation.transpose() * motion.translation)};
}

}  // namespace diffsac
