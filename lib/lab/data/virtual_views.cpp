#include "lab/data/virtual_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace diffsac {

bool VirtualCamera::Contains(const Eigen::Vector2d& pixel) const {
  return pixel[0] >= 0.0 && pixel[1] >= 0.0 && pixel[0] <= size.width && pixel[1] <= size.height;
}

Eigen::Vector3d VirtualCamera::Ray(const Eigen::Vector2d& pixel) const {
  return {(pixel[0] - K(0, 2)) / K(0, 0), (pixel[1] - K(1, 2)) / K(1, 1), 1.0};
}

Eigen::Vector2d VirtualCamera::RandomPixel(Rng& rng) const {
  const double x = rng.Uniform(0.0, size.width);
  return {x, rng.Uniform(0.0, size.height)};
}

bool ProjectIntoBoth(const VirtualPair& pair, const Eigen::Vector3d& point, double least_depth,
                     Eigen::Vector4d* match) {
  const Eigen::Vector3d moved = pair.motion.rotation * point + pair.motion.translation;
  if (!(point[2] > least_depth && moved[2] > least_depth)) return false;
  const Eigen::Vector2d pixel1 = (pair.first.K * point).hnormalized();
  const Eigen::Vector2d pixel2 = (pair.second.K * moved).hnormalized();
  if (!pair.first.Contains(pixel1) || !pair.second.Contains(pixel2)) return false;
  *match << pixel1, pixel2;
  return true;
}

void VirtualCameraOptions::Bind(OptionsBinder& b) {
  b.Field("principal_offset", principal_offset, Within(0.0, 0.5))
      .Help("the principal point is off the centre by up to this share of each side");
}

VirtualCamera RandomCamera(const VirtualCameraOptions& options, Rng rng) {
  VirtualCamera camera;
  const double width = LogUniform(options.image_width, rng);
  const double aspect = LogUniform(options.image_aspect, rng);
  camera.size = {std::max(1, static_cast<int>(std::lround(width))),
                 std::max(1, static_cast<int>(std::lround(width * aspect)))};
  const double focal = LogUniform(options.focal, rng) * std::max(camera.size.width, camera.size.height);
  const double offset_x = options.principal_offset * rng.Uniform(-1.0, 1.0);
  const double offset_y = options.principal_offset * rng.Uniform(-1.0, 1.0);
  camera.K << focal, 0.0, (0.5 + offset_x) * camera.size.width,  //
      0.0, focal, (0.5 + offset_y) * camera.size.height,         //
      0.0, 0.0, 1.0;
  return camera;
}

VirtualCamera RandomSecondCamera(const VirtualCameraOptions& options, const VirtualCamera& first, Rng rng) {
  return rng.Uniform() < options.same_camera ? first : RandomCamera(options, rng.Fork("camera"));
}

Eigen::Vector3d RandomDirection(Rng& rng) {
  for (;;) {
    Eigen::Vector3d v;
    for (double& value : v) value = rng.Normal();
    if (v.norm() > 1e-6) return v.normalized();
  }
}

Eigen::Vector3d Tilted(const Eigen::Vector3d& axis, double degrees, Rng& rng) {
  const Eigen::Vector3d side = axis.unitOrthogonal();
  const double azimuth = rng.Uniform(0.0, 2.0 * std::numbers::pi), angle = degrees * std::numbers::pi / 180.0;
  const Eigen::Vector3d direction = std::cos(azimuth) * side + std::sin(azimuth) * axis.cross(side);
  return std::cos(angle) * axis + std::sin(angle) * direction;
}

Eigen::Matrix3d RandomRotation(double degrees, Rng& rng) {
  const Eigen::Vector3d axis = RandomDirection(rng);
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis).toRotationMatrix();
}

double LogUniform(const Range& range, Rng& rng) { return range.low * std::pow(range.high / range.low, rng.Uniform()); }

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
