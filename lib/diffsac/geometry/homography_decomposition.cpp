#include "diffsac/geometry/homography_decomposition.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "diffsac/geometry/svd3.h"

namespace diffsac {
namespace {

/// Spread of the singular values below which the homography is a rotation.
constexpr double kRotationSpread = 1e-9;

}  // namespace

PlaneMotions DecomposeHomography(const Eigen::Matrix3d& h, const Eigen::Matrix3d& k1, const Eigen::Matrix3d& k2) {
  PlaneMotions result;
  Eigen::Matrix3d calibrated = k2.inverse() * h * k1;
  const Svd3 svd = ComputeSvd3(calibrated);
  Eigen::Vector3d values = svd.values;
  if (!(values[2] > 1e-14 * values[0])) return result;
  // R + t nᵀ has the middle singular value 1 and, with both cameras on one side of the plane, a positive determinant.
  calibrated /= calibrated.determinant() < 0.0 ? -values[1] : values[1];
  values /= values[1];
  if (values[0] - values[2] < kRotationSpread) {
    const Svd3 rotation = ComputeRotationSvd3(calibrated);
    result.count = 1;
    result.motions[0].rotation = rotation.u * rotation.v.transpose();
    return result;
  }
  // Two directions u lie in planes that H maps without stretching: |H u| = |u|.
  const double above = (values[0] - 1.0) * (values[0] + 1.0), below = (1.0 - values[2]) * (1.0 + values[2]);
  const double spread = std::sqrt((values[0] - values[2]) * (values[0] + values[2]));
  const double first = std::sqrt(std::max(below, 0.0)) / spread, third = std::sqrt(std::max(above, 0.0)) / spread;
  const Eigen::Matrix3d& v = svd.v;
  const Eigen::Vector3d axis = v.col(1);
  for (const double sign : {1.0, -1.0}) {
    const Eigen::Vector3d kept = first * v.col(0) + sign * third * v.col(2);
    Eigen::Matrix3d from, to;
    from << axis, kept, axis.cross(kept);
    const Eigen::Vector3d axis_image = calibrated * axis, kept_image = calibrated * kept;
    to << axis_image, kept_image, axis_image.cross(kept_image);
    PlaneMotion motion;
    motion.rotation = to * from.transpose();
    motion.normal = axis.cross(kept);
    motion.translation = (calibrated - motion.rotation) * motion.normal;
    result.motions[result.count++] = motion;
    result.motions[result.count++] = {motion.rotation, -motion.translation, -motion.normal};
  }
  return result;
}

PlaneMotions KeepVisible(const PlaneMotions& motions, const PointMatrix& points, const Eigen::Matrix3d& k1) {
  const Eigen::Matrix3d inverse = k1.inverse();
  PlaneMotions visible;
  for (int i = 0; i < motions.count; ++i) {
    const Eigen::Vector3d direction = inverse.transpose() * motions.motions[i].normal;
    bool all = true;
    for (Eigen::Index row = 0; row < points.rows() && all; ++row)
      all = direction[0] * points(row, 0) + direction[1] * points(row, 1) + direction[2] > 0.0;
    if (all || motions.count == 1) visible.motions[visible.count++] = motions.motions[i];
  }
  return visible;
}

}  // namespace diffsac
