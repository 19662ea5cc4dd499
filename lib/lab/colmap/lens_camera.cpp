#include "lab/colmap/lens_camera.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace diffsac {
namespace {

// What distortion adds to a point in coordinates K⁻¹ x.
Eigen::Vector2d Shift(const LensCamera& camera, const Eigen::Vector2d& point) {
  const double x = point.x(), y = point.y(), r2 = point.squaredNorm();
  const double radial = camera.k1 * r2 + camera.k2 * r2 * r2;
  return {x * radial + 2.0 * camera.p1 * x * y + camera.p2 * (r2 + 2.0 * x * x),
          y * radial + 2.0 * camera.p2 * x * y + camera.p1 * (r2 + 2.0 * y * y)};
}

}  // namespace

bool LensCamera::IsStraight() const { return !lens && k1 == 0.0 && k2 == 0.0 && p1 == 0.0 && p2 == 0.0; }

Eigen::Vector2d LensCamera::Undistort(const Eigen::Vector2d& pixel) const {
  if (lens) return lens->Undistort(pixel).value_or(Eigen::Vector2d::Constant(std::nan("")));
  if (IsStraight()) return pixel;
  const Eigen::Vector2d seen = (K.inverse() * pixel.homogeneous()).hnormalized();
  // A fixed point, which usual lenses reach in a few rounds.
  Eigen::Vector2d point = seen;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d next = seen - Shift(*this, point);
    const bool done = (next - point).norm() < 1e-14;
    point = next;
    if (done) break;
  }
  return (K * point.homogeneous()).hnormalized();
}

Eigen::Vector2d LensCamera::Distort(const Eigen::Vector2d& pixel) const {
  if (lens) return lens->Distort(pixel);
  const Eigen::Vector2d point = (K.inverse() * pixel.homogeneous()).hnormalized();
  return (K * (point + Shift(*this, point)).homogeneous()).hnormalized();
}

}  // namespace diffsac
