#include "diffsac/eval/two_view_metrics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diffsac/geometry/pose.h"

namespace diffsac {
namespace {

constexpr int kFewestInliers = 5;
constexpr int kGrid = 10;

bool HasModel(const Estimate& estimate) {
  return estimate.status == Status::kOk && estimate.model.size() == 9 && estimate.model.allFinite();
}

Eigen::Matrix3d ModelMatrix(const ModelParameters& model) { return AsMatrix(Matrix3Parameters(model)); }

/// The direction's error, either sign.
double TranslationError(const Eigen::Vector3d& estimate, const Eigen::Vector3d& truth) {
  if (truth.norm() == 0.0) return 0.0;
  const double angle = DirectionAngleDegrees(estimate, truth);
  return std::min(angle, 180.0 - angle);
}

EstimateError PoseError(const Estimate& estimate, const Example& example) {
  EstimateError error;
  error.failed = !HasModel(estimate);
  if (!example.truth.pose || !example.problem.cameras) return error;
  const CameraPair& cameras = *example.problem.cameras;
  error.rotation_deg = kWorstRotationDeg;
  error.translation_deg = kWorstTranslationDeg;
  const auto inliers = std::count(estimate.inliers.begin(), estimate.inliers.end(), 1);
  if (!error.failed && inliers >= kFewestInliers) {
    Eigen::Matrix3d essential = ModelMatrix(estimate.model);
    if (example.problem.task == Task::kFundamental)
      essential = EssentialFromFundamental(essential, cameras.K1, cameras.K2);
    const PointMatrix points = NormalizedCoordinates(example.problem.points, cameras.K1, cameras.K2);
    const PoseChoice choice = ChoosePose(essential, points, estimate.inliers);
    if (choice.in_front > 0) {
      error.rotation_deg = RotationAngleDegrees(choice.pose.rotation, example.truth.pose->rotation);
      error.translation_deg = TranslationError(choice.pose.translation, example.truth.pose->translation);
    } else {
      error.failed = true;
    }
  } else {
    error.failed = true;
  }
  error.angle_deg = std::max(error.rotation_deg, error.translation_deg);
  return error;
}

Eigen::Vector2d Transfer(const Eigen::Matrix3d& h, double x, double y) {
  return (h * Eigen::Vector3d(x, y, 1.0)).hnormalized();
}

EstimateError HomographyError(const Estimate& estimate, const Example& example) {
  EstimateError error;
  error.failed = !HasModel(estimate);
  if (example.truth.model.size() != 9) return error;
  error.transfer_px = std::numeric_limits<double>::infinity();
  if (error.failed || example.problem.points.rows() == 0) return error;
  const Eigen::Matrix3d found = ModelMatrix(estimate.model), truth = ModelMatrix(example.truth.model);
  const Eigen::RowVectorXd low = example.problem.points.colwise().minCoeff();
  const Eigen::RowVectorXd high = example.problem.points.colwise().maxCoeff();
  double sum = 0.0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double x = low[0] + (high[0] - low[0]) * i / (kGrid - 1), y = low[1] + (high[1] - low[1]) * j / (kGrid - 1);
      sum += (Transfer(found, x, y) - Transfer(truth, x, y)).norm();
    }
  error.transfer_px = std::isfinite(sum) ? sum / (kGrid * kGrid) : std::numeric_limits<double>::infinity();
  return error;
}

}  // namespace

EstimateError MeasureTwoViewError(const Estimate& estimate, const Example& example) {
  return example.problem.task == Task::kHomography ? HomographyError(estimate, example) : PoseError(estimate, example);
}

}  // namespace diffsac
