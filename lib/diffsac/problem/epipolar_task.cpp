#include "diffsac/problem/epipolar_task.h"

#include <algorithm>
#include <cmath>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/pose.h"

namespace diffsac {
namespace {

constexpr int kFewestInliers = 5;

}  // namespace

std::optional<RigidMotion> EpipolarPose(const Eigen::Matrix3d& essential, const PointMatrix& points,
                                        const std::vector<std::uint8_t>& inliers, double noise) {
  if (std::count(inliers.begin(), inliers.end(), 1) < kFewestInliers) return std::nullopt;
  const PoseChoice choice = ChoosePose(essential, points, inliers, noise);
  if (choice.in_front <= 0) return std::nullopt;
  return RigidMotion{choice.pose.rotation, choice.pose.translation};
}

double LeaveOutBehind(const RigidMotion& pose, const PointMatrix& points, double tolerance,
                      std::vector<std::uint8_t>* inliers) {
  const RelativePose relative{pose.rotation, pose.translation};
  int count = 0, behind = 0;
  for (std::size_t i = 0; i < inliers->size(); ++i) {
    if ((*inliers)[i] == 0) continue;
    ++count;
    if (PassesCheirality(relative, &points(static_cast<Eigen::Index>(i), 0), tolerance)) continue;
    (*inliers)[i] = 0;
    ++behind;
  }
  return count > 0 ? static_cast<double>(behind) / static_cast<double>(count) : 0.0;
}

}  // namespace diffsac
