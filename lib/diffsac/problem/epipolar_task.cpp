#include "diffsac/problem/epipolar_task.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

EstimateError EpipolarPoseError(const Eigen::Matrix3d* essential, const CameraPair& cameras,
                                const std::vector<std::uint8_t>& inliers, const Example& example) {
  EstimateError error;
  error.rotation_deg = kWorstRotationDeg;
  error.translation_deg = kWorstTranslationDeg;
  std::optional<RigidMotion> pose;
  if (essential != nullptr) pose = EpipolarPose(*essential, cameras, inliers, example.problem.points);
  error.failed = !pose;
  if (pose) {
    error.rotation_deg = RotationAngleDegrees(pose->rotation, example.truth.pose->rotation);
    error.translation_deg = TranslationErrorDegrees(pose->translation, example.truth.pose->translation);
  }
  error.angle_deg = std::max(error.rotation_deg, error.translation_deg);
  return error;
}

EstimateError EpipolarInlierError(const Matrix3Parameters* fundamental, const Example& example) {
  EstimateError error;
  error.failed = fundamental == nullptr;
  const auto& inliers = example.truth.inliers;
  const auto count = std::count(inliers.begin(), inliers.end(), 1);
  if (count == 0) return error;
  error.error_px = std::numeric_limits<double>::infinity();
  if (error.failed) return error;
  double sum = 0.0;
  for (std::size_t i = 0; i < inliers.size(); ++i)
    if (inliers[i]) sum += SampsonError(*fundamental, example.problem.points.row(i).data());
  if (std::isfinite(sum)) error.error_px = sum / static_cast<double>(count);
  return error;
}

}  // namespace diffsac
