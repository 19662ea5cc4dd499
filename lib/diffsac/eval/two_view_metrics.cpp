#include "diffsac/eval/two_view_metrics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diffsac/geometry/epipolar.h"
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

/// Pixels: an E lives in normalised coordinates, so it is brought back to an F.
EstimateError InlierError(const Estimate& estimate, const Example& example) {
  EstimateError error;
  error.failed = !HasModel(estimate);
  const auto& inliers = example.truth.inliers;
  const auto count = std::count(inliers.begin(), inliers.end(), 1);
  if (count == 0) return error;
  error.error_px = std::numeric_limits<double>::infinity();
  if (error.failed) return error;
  Matrix3Parameters model = estimate.model;
  if (example.problem.task == Task::kEssential && example.problem.cameras) {
    const auto& [K1, K2] = *example.problem.cameras;
    model = AsParameters(K2.inverse().transpose() * ModelMatrix(model) * K1.inverse());
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < inliers.size(); ++i)
    if (inliers[i]) sum += SampsonError(model, example.problem.points.row(i).data());
  if (std::isfinite(sum)) error.error_px = sum / static_cast<double>(count);
  return error;
}

EstimateError PoseError(const Estimate& estimate, const Example& example) {
  if (!example.truth.pose || !example.problem.cameras) return InlierError(estimate, example);
  EstimateError error;
  error.failed = !HasModel(estimate);
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
  error.error_px = std::numeric_limits<double>::infinity();
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
  error.error_px = std::isfinite(sum) ? sum / (kGrid * kGrid) : std::numeric_limits<double>::infinity();
  return error;
}

}  // namespace

EstimateError MeasureTwoViewError(const Estimate& estimate, const Example& example) {
  return example.problem.task == Task::kHomography ? HomographyError(estimate, example) : PoseError(estimate, example);
}

}  // namespace diffsac
