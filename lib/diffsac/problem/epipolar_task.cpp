#include "diffsac/problem/epipolar_task.h"

#include <algorithm>
#include <cmath>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/pose.h"

namespace diffsac {
namespace {

constexpr int kFewestInliers = 5;

}  // namespace

std::optional<RigidMotion> EpipolarPose(const Eigen::Matrix3d& essential, const CameraPair& cameras,
                                        const std::vector<std::uint8_t>& inliers, const PointMatrix& pixels,
                                        double noise_px) {
  if (std::count(inliers.begin(), inliers.end(), 1) < kFewestInliers) return std::nullopt;
  const PointMatrix points = NormalizedCoordinates(pixels, cameras.K1, cameras.K2);
  const PoseChoice choice = ChoosePose(essential, points, inliers, noise_px / cameras.MeanFocal());
  if (choice.in_front <= 0) return std::nullopt;
  return RigidMotion{choice.pose.rotation, choice.pose.translation};
}

ParallaxTest CalibratedParallax(const Eigen::Matrix3d& essential, const CameraPair& cameras,
                                const std::vector<std::uint8_t>& inliers, const PointMatrix& pixels) {
  return TestTurn(NormalizedCoordinates(pixels, cameras.K1, cameras.K2), AsParameters(essential), inliers);
}

double LeaveOutBehind(const std::optional<RigidMotion>& pose, const PointMatrix& points, double tolerance,
                      std::vector<std::uint8_t>* inliers) {
  if (!pose) return 0.0;
  const RelativePose relative{pose->rotation, pose->translation};
  int count = 0, behind = 0;
  for (std::size_t i = 0; i < inliers->size(); ++i) {
    if ((*inliers)[i] == 0) continue;
    ++count;
    if (MayBeInFront(relative, &points(static_cast<Eigen::Index>(i), 0), tolerance)) continue;
    (*inliers)[i] = 0;
    ++behind;
  }
  return static_cast<double>(behind) / static_cast<double>(count);
}

}  // namespace diffsac
