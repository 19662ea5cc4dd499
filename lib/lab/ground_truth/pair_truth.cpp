#include "lab/ground_truth/pair_truth.h"

#include <cmath>
#include <limits>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/problem/tasks.h"
#include "lab/ground_truth/task_truth.h"

namespace diffsac {
namespace {

std::vector<std::uint8_t> TrueInliers(const Problem& problem, const GroundTruth& truth) {
  std::vector<std::uint8_t> inliers;
  for (const std::int32_t label : truth.assignment) inliers.push_back(label > 0);
  if (!inliers.empty()) return inliers;
  const Eigen::VectorXd distances = TruthDistances(problem, truth);
  for (const double distance : distances) inliers.push_back(distance <= problem.inlier_threshold);
  return inliers;
}

}  // namespace

Eigen::Matrix3d EssentialFromMotion(const RigidMotion& motion) {
  return EssentialFromPose({motion.rotation, motion.translation});
}

RelativePose PoseOf(const RigidMotion& motion) {
  const double length = motion.translation.norm();
  return {motion.rotation,
          length > 0.0 ? Eigen::Vector3d(motion.translation / length) : Eigen::Vector3d(motion.translation)};
}

void CompleteTruth(const Problem& problem, GroundTruth* truth) {
  if (!truth->essential && truth->motion) truth->essential = EssentialFromMotion(*truth->motion);
  if (!problem.cameras) return;
  const auto& [K1, K2] = *problem.cameras;
  if (!truth->essential && truth->fundamental) truth->essential = EssentialFromFundamental(*truth->fundamental, K1, K2);
  if (!truth->fundamental && truth->essential) truth->fundamental = FundamentalFromEssential(*truth->essential, K1, K2);
}

Eigen::VectorXd TruthDistances(const Problem& problem, const GroundTruth& truth) {
  if (!truth.homography && !truth.fundamental) return {};
  const PointMatrix& points = problem.points;
  const Matrix3Parameters model = AsParameters(truth.homography ? *truth.homography : *truth.fundamental);
  Eigen::VectorXd distances(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double* point = points.data() + i * points.cols();
    const double distance = truth.homography ? TransferError(model, point) : SampsonError(model, point);
    distances[i] = std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity();
  }
  return distances;
}

ModelParameters TrueModel(const Problem& problem, const GroundTruth& truth) {
  const auto model = TruthOf(problem.task).true_model;
  return model != nullptr ? model(problem, truth) : ModelParameters();
}

void HideCalibration(Example* pair) {
  DispatchDescription(pair->problem.task, [&]<class Description>() {
    if constexpr (requires { Description::kUnknownFocal; }) {
      if (!pair->problem.cameras) return;
      if (Description::kUnknownFocal == UnknownFocal::kSecond)
        pair->problem.camera_prior1.K = pair->problem.cameras->K1;
      pair->truth.cameras = pair->problem.cameras;
      pair->problem.cameras.reset();
    }
  });
}

void SetTask(Task task, double inlier_threshold_px, Example* pair) {
  pair->problem.task = task;
  SetThreshold(inlier_threshold_px, &pair->problem);
  HideCalibration(pair);
  pair->truth.model = TrueModel(pair->problem, pair->truth);
  pair->truth.pose.reset();
  if (pair->truth.motion) pair->truth.pose = PoseOf(*pair->truth.motion);
  pair->truth.inliers = TrueInliers(pair->problem, pair->truth);
}

}  // namespace diffsac
