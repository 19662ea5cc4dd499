#include "diffsac/eval/two_view_metrics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/homography_decomposition.h"
#include "diffsac/geometry/pose.h"

namespace diffsac {
namespace {

constexpr int kFewestInliers = 5;
constexpr int kBoxGrid = 10;

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

/// Homogeneous pixels of image 1, whose true transfer is before the second camera where w has this sign.
double FrontSign(const Eigen::Matrix3d& truth, const Example& example) {
  const PointMatrix& points = example.problem.points;
  const auto& inliers = example.truth.inliers;
  const bool labelled = inliers.size() == static_cast<std::size_t>(points.rows());
  int balance = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (labelled && !inliers[i]) continue;
    const double w = truth.row(2).dot(Eigen::RowVector3d(points(i, 0), points(i, 1), 1.0));
    balance += w > 0.0 ? 1 : w < 0.0 ? -1 : 0;
  }
  return balance < 0 ? -1.0 : 1.0;
}

std::vector<Eigen::Vector2d> BoxGrid(const PointMatrix& points) {
  std::vector<Eigen::Vector2d> grid;
  if (points.rows() == 0) return grid;
  const Eigen::RowVectorXd low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
  for (int i = 0; i < kBoxGrid; ++i)
    for (int j = 0; j < kBoxGrid; ++j)
      grid.emplace_back(low[0] + (high[0] - low[0]) * i / (kBoxGrid - 1),
                        low[1] + (high[1] - low[1]) * j / (kBoxGrid - 1));
  return grid;
}

/// The least error among the motions of the homography that leave the inliers before the camera: which of the mostly
/// two is meant, one homography cannot tell.
void AddMotionError(const Estimate& estimate, const Example& example, EstimateError* error) {
  if (!example.truth.pose || !example.problem.cameras) return;
  error->rotation_deg = kWorstRotationDeg;
  error->translation_deg = kWorstTranslationDeg;
  const auto& [K1, K2] = *example.problem.cameras;
  std::vector<int> inliers;
  for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
    if (estimate.inliers[i]) inliers.push_back(static_cast<int>(i));
  PlaneMotions motions;
  if (!error->failed) {
    motions = DecomposeHomography(ModelMatrix(estimate.model), K1, K2);
    const PlaneMotions visible = KeepVisible(motions, example.problem.points(inliers, Eigen::all), K1);
    if (visible.count > 0) motions = visible;
  }
  for (int i = 0; i < motions.count; ++i) {
    const double rotation = RotationAngleDegrees(motions.motions[i].rotation, example.truth.pose->rotation);
    const double translation = TranslationError(motions.motions[i].translation, example.truth.pose->translation);
    if (std::max(rotation, translation) >= std::max(error->rotation_deg, error->translation_deg)) continue;
    error->rotation_deg = rotation;
    error->translation_deg = translation;
  }
  error->angle_deg = std::max(error->rotation_deg, error->translation_deg);
}

EstimateError HomographyError(const Estimate& estimate, const Example& example) {
  EstimateError error;
  error.failed = !HasModel(estimate);
  AddMotionError(estimate, example, &error);
  if (example.truth.model.size() != 9) return error;
  error.error_px = std::numeric_limits<double>::infinity();
  if (error.failed) return error;
  const Eigen::Matrix3d found = ModelMatrix(estimate.model), truth = ModelMatrix(example.truth.model);
  std::vector<Eigen::Vector2d> grid = JointlyVisiblePixels(example);
  if (grid.empty()) grid = BoxGrid(example.problem.points);
  if (grid.empty()) return error;
  double sum = 0.0;
  for (const Eigen::Vector2d& pixel : grid)
    sum += ((found * pixel.homogeneous()).hnormalized() - (truth * pixel.homogeneous()).hnormalized()).norm();
  if (std::isfinite(sum)) error.error_px = sum / static_cast<double>(grid.size());
  return error;
}

}  // namespace

std::vector<Eigen::Vector2d> JointlyVisiblePixels(const Example& example) {
  std::vector<Eigen::Vector2d> pixels;
  const ImageSize &size1 = example.problem.size1, &size2 = example.problem.size2;
  if (!size1.known() || !size2.known() || example.truth.model.size() != 9) return pixels;
  const Eigen::Matrix3d truth = ModelMatrix(example.truth.model);
  const double front = FrontSign(truth, example);
  for (int y = kVisibleStep / 2; y < size1.height; y += kVisibleStep)
    for (int x = kVisibleStep / 2; x < size1.width; x += kVisibleStep) {
      const Eigen::Vector3d moved = truth * Eigen::Vector3d(x, y, 1.0);
      if (!(front * moved[2] > 0.0)) continue;
      const Eigen::Vector2d there = moved.hnormalized();
      if (there[0] >= 0.0 && there[0] <= size2.width - 1 && there[1] >= 0.0 && there[1] <= size2.height - 1)
        pixels.emplace_back(x, y);
    }
  return pixels;
}

EstimateError MeasureTwoViewError(const Estimate& estimate, const Example& example) {
  return example.problem.task == Task::kHomography ? HomographyError(estimate, example) : PoseError(estimate, example);
}

}  // namespace diffsac
