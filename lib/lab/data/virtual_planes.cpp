#include "lab/data/virtual_planes.h"

#include <Eigen/Geometry>

namespace diffsac {
namespace {

// A plane is seen up to this factor beyond the nearest and farthest depths.
constexpr double kPlaneDepthFactor = 2.0;
// How far camera 2 stays from the plane, as a share of the distance of camera 1.
constexpr double kLeastPlaneDistance = 0.05;

}  // namespace

Eigen::Matrix3d VirtualPlane::Homography(const VirtualPair& pair) const {
  Eigen::Matrix3d h = pair.motion.rotation;
  h += pair.motion.translation * normal.transpose() / distance;
  return pair.second.K * h * pair.first.K.inverse();
}

bool VirtualPlane::FacesBoth(const RigidMotion& motion) const {
  const Eigen::Vector3d centre2 = -(motion.rotation.transpose() * motion.translation);
  return distance - normal.dot(centre2) > kLeastPlaneDistance * distance;
}

bool VirtualPlane::Match(const VirtualPair& pair, const Range& depths, const Eigen::Vector2d& pixel,
                         Eigen::Vector4d* match) const {
  const Eigen::Vector3d ray = pair.first.Ray(pixel);
  const double depth = distance / normal.dot(ray);
  if (!(depth > depths.low / kPlaneDepthFactor && depth < depths.high * kPlaneDepthFactor)) return false;
  return ProjectIntoBoth(pair, ray * depth, kLeastDepth, match);
}

RigidMotion MotionTo(const Eigen::Vector3d& centre2, const Eigen::Matrix3d& turn, std::optional<double> towards) {
  RigidMotion motion;
  motion.rotation = turn;
  if (towards) {
    const Eigen::Vector3d direction = Eigen::Vector3d(0.0, 0.0, *towards) - centre2;
    motion.rotation *= Eigen::Quaterniond::FromTwoVectors(direction, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  motion.translation = -(motion.rotation * centre2);
  return motion;
}

}  // namespace diffsac
