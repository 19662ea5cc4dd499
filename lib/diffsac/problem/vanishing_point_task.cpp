#include "diffsac/problem/vanishing_point_task.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "diffsac/geometry/pose.h"
#include "diffsac/problem/coordinates.h"
#include "diffsac/problem/shared_focal_task.h"

namespace diffsac {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

struct Box {
  Eigen::RowVector2d low, high;

  explicit Box(const PointMatrix& points) {
    const Eigen::RowVector4d least = points.colwise().minCoeff(), most = points.colwise().maxCoeff();
    low = least.head<2>().cwiseMin(least.tail<2>());
    high = most.head<2>().cwiseMax(most.tail<2>());
  }
};

/// Width and height of the image, or of the segments' box; 0 where there is neither.
Eigen::Vector2d ExtentOf(const Problem& problem) {
  if (problem.size1.known()) return {problem.size1.width, problem.size1.height};
  if (problem.points.rows() == 0) return Eigen::Vector2d::Zero();
  const Box box(problem.points);
  return (box.high - box.low).transpose();
}

Eigen::Vector3d Unit(const Eigen::Vector3d& v) {
  const double length = v.norm();
  return length > 0.0 ? Eigen::Vector3d(v / length) : v;
}

}  // namespace

Eigen::Matrix3d SegmentCamera(const Problem& problem) {
  if (problem.cameras) return problem.cameras->K1;
  const ImageSize& size = problem.size1;
  if (size.known()) return CentredCamera(kUsualFocal * std::max(size.width, size.height), size);
  const PointMatrix& points = problem.points;
  if (points.rows() == 0 || points.cols() != 4 || !points.allFinite()) return Eigen::Matrix3d::Identity();
  const Box box(points);
  const double longer_side = (box.high - box.low).maxCoeff(),
               focal = longer_side > 0.0 ? kUsualFocal * longer_side : 1.0;
  Eigen::Matrix3d K = Eigen::Vector3d(focal, focal, 1.0).asDiagonal();
  K.topRightCorner<2, 1>() = 0.5 * (box.low + box.high).transpose();
  return K;
}

PointMatrix VanishingPointTask::Normalize(const Problem& problem, double* unit) {
  *unit = kDegrees;
  const Eigen::Matrix3d K = SegmentCamera(problem);
  return NormalizedCoordinates(problem.points, K, K);
}

PointMatrix VanishingPointTask::FeatureCoordinates(const NormalizedProblem& space) {
  // The middle; and the line, whose sign says nothing, as a direction of double angle, the longer the longer it is.
  constexpr double kUnit = 0.25;
  const PointMatrix& points = space.points();
  PointMatrix coordinates(points.rows(), 4);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double x = points(i, 2) - points(i, 0), y = points(i, 3) - points(i, 1);
    const double angle = 2.0 * std::atan2(y, x), size = std::sqrt(std::hypot(x, y) / kUnit);
    coordinates.row(i) << 0.5 * (points(i, 0) + points(i, 2)), 0.5 * (points(i, 1) + points(i, 3)),
        size * std::cos(angle), size * std::sin(angle);
  }
  return coordinates;
}

PointMatrix VanishingPointTask::ImagePoints(const Problem& problem) {
  return 0.5 * (problem.points.leftCols(2) + problem.points.rightCols(2));
}

Eigen::VectorXd VanishingPointTask::PointWeights(const Problem& problem) {
  const Eigen::VectorXd lengths = (problem.points.rightCols(2) - problem.points.leftCols(2)).rowwise().norm();
  const double diagonal = ExtentOf(problem).norm();
  return diagonal > 0.0 && std::isfinite(diagonal) ? Eigen::VectorXd((lengths / diagonal).cwiseMin(1.0)) : lengths;
}

double VanishingPointTask::ChanceShare(const Problem&, double threshold) { return std::min(1.0, threshold / 90.0); }

Eigen::Vector3d VanishingPointTask::PixelPoint(const ModelParameters& model, const Problem& problem) {
  return Unit(SegmentCamera(problem) * Eigen::Vector3d(model));
}

ModelParameters VanishingPointTask::ModelOf(const Eigen::Vector3d& pixel_point, const Problem& problem) {
  return Unit(SegmentCamera(problem).inverse() * pixel_point);
}

}  // namespace diffsac
