#include "diffsac/problem/homography_task.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/geometry/homography_decomposition.h"
#include "diffsac/geometry/pose.h"

namespace diffsac {
namespace {

constexpr int kBoxGrid = 10;

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

/// The motions that leave the inliers before the camera, or all where none does.
PlaneMotions MotionsOf(const Eigen::Matrix3d& model, const std::vector<std::uint8_t>& inliers, const Problem& problem) {
  const auto& [K1, K2] = *problem.cameras;
  std::vector<int> rows;
  for (std::size_t i = 0; i < inliers.size(); ++i)
    if (inliers[i]) rows.push_back(static_cast<int>(i));
  const PlaneMotions motions = DecomposeHomography(model, K1, K2);
  const PlaneMotions visible = KeepVisible(motions, problem.points(rows, Eigen::all), K1);
  return visible.count > 0 ? visible : motions;
}

/// The least error among the motions: which of the mostly two is meant, one homography cannot tell.
void AddMotionError(const ModelParameters* model, const std::vector<std::uint8_t>& inliers, const Example& example,
                    EstimateError* error) {
  if (!example.truth.pose || !example.problem.cameras) return;
  error->rotation_deg = kWorstRotationDeg;
  error->translation_deg = kWorstTranslationDeg;
  PlaneMotions motions;
  if (model != nullptr) motions = MotionsOf(ModelMatrix(*model), inliers, example.problem);
  for (int i = 0; i < motions.count; ++i) {
    const double rotation = RotationAngleDegrees(motions.motions[i].rotation, example.truth.pose->rotation);
    const double translation = TranslationErrorDegrees(motions.motions[i].translation, example.truth.pose->translation);
    if (std::max(rotation, translation) >= std::max(error->rotation_deg, error->translation_deg)) continue;
    error->rotation_deg = rotation;
    error->translation_deg = translation;
  }
  error->angle_deg = std::max(error->rotation_deg, error->translation_deg);
}

}  // namespace

EstimateError HomographyError(const ModelParameters* model, const std::vector<std::uint8_t>& inliers,
                              const Example& example) {
  EstimateError error;
  error.failed = model == nullptr;
  AddMotionError(model, inliers, example, &error);
  if (example.truth.model.size() != 9) return error;
  error.error_px = std::numeric_limits<double>::infinity();
  if (error.failed) return error;
  const Eigen::Matrix3d found = ModelMatrix(*model), truth = ModelMatrix(example.truth.model);
  std::vector<Eigen::Vector2d> grid = JointlyVisiblePixels(example);
  if (grid.empty()) grid = BoxGrid(example.problem.points);
  if (grid.empty()) return error;
  double sum = 0.0;
  for (const Eigen::Vector2d& pixel : grid)
    sum += ((found * pixel.homogeneous()).hnormalized() - (truth * pixel.homogeneous()).hnormalized()).norm();
  if (std::isfinite(sum)) error.error_px = sum / static_cast<double>(grid.size());
  return error;
}

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

}  // namespace diffsac
