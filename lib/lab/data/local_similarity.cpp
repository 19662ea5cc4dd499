#include "lab/data/local_similarity.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace diffsac {
namespace {

// How far, in pixels, an exact match may be from its plane's homography by rounding.
constexpr double kOnPlanePx = 1e-6;

Eigen::Vector2d Mapped(const Eigen::Matrix3d& H, const Eigen::Vector2d& pixel) {
  return (H * pixel.homogeneous()).hnormalized();
}

// Of the patch at a match.
Eigen::Matrix3d PatchHomography(const VirtualPair& pair, const Eigen::Vector4d& match) {
  const RigidMotion& motion = pair.motion;
  const Eigen::Vector3d ray1 = pair.first.Ray(match.head<2>()), ray2 = pair.second.Ray(match.tail<2>());
  Eigen::Matrix3d between = motion.rotation;
  // Depths z1, z2 with z2 ray2 = z1 R ray1 + t. There are none at an epipole, and without a baseline.
  Eigen::Matrix<double, 3, 2> rays;
  rays << -motion.rotation * ray1, ray2;
  const Eigen::Vector2d depths = rays.colPivHouseholderQr().solve(motion.translation);
  if (depths.minCoeff() > 0.0) {
    const Eigen::Vector3d normal = (ray1.normalized() + motion.rotation.transpose() * ray2.normalized()).normalized();
    between += motion.translation * normal.transpose() / (depths[0] * normal.dot(ray1));
  }
  return pair.second.K * between * pair.first.K.inverse();
}

Eigen::Matrix3d HomographyAt(const VirtualPair& pair, const std::vector<Eigen::Matrix3d>& planes,
                             const Eigen::Vector4d& match) {
  for (const Eigen::Matrix3d& H : planes)
    if ((Mapped(H, match.head<2>()) - match.tail<2>()).norm() < kOnPlanePx) return H;
  return PatchHomography(pair, match);
}

}  // namespace

Eigen::RowVector2d LocalSimilarity(const VirtualPair& pair, const std::vector<Eigen::Matrix3d>& planes,
                                   const Eigen::Vector4d& match) {
  const Eigen::Matrix3d H = HomographyAt(pair, planes, match);
  const Eigen::Vector3d image = H * match.head<2>().homogeneous();
  // The derivative of the mapping.
  const Eigen::Matrix2d A = (H.topLeftCorner<2, 2>() - image.hnormalized() * H.bottomLeftCorner<1, 2>()) / image[2];
  const Eigen::Vector2d similar(A(0, 0) + A(1, 1), A(1, 0) - A(0, 1));
  return {std::log(0.5 * similar.norm()), std::atan2(similar[1], similar[0])};
}

}  // namespace diffsac
