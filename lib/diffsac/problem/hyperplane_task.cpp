#include "diffsac/problem/hyperplane_task.h"

#include <cmath>

namespace diffsac {
namespace {

double OffsetDifference(const ModelParameters& a, const ModelParameters& b, const PointMatrix& points) {
  const Eigen::Index d = points.cols();
  const Eigen::VectorXd centroid = points.colwise().mean();
  const double side = a.head(d).dot(b.head(d)) < 0.0 ? -1.0 : 1.0;
  return std::abs(a.head(d).dot(centroid) + a[d] - side * (b.head(d).dot(centroid) + b[d]));
}

double BoundingDiagonal(const PointMatrix& points) {
  if (points.rows() == 0) return 0.0;
  return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
}

}  // namespace

EstimateError HyperplaneError(const ModelParameters* model, const Example& example) {
  const ModelParameters& truth = example.truth.model;
  const PointMatrix& points = example.problem.points;
  EstimateError error;
  error.failed = model == nullptr;
  if (truth.size() == 0) return error;
  if (error.failed) {
    error.angle_deg = kWorstAngleDeg;
    error.offset = BoundingDiagonal(points);
  } else {
    error.angle_deg = AngleBetweenDegrees(*model, truth);
    error.offset = OffsetDifference(*model, truth, points);
  }
  return error;
}

LinearEquations HyperplaneEquations(const PointMatrix& points, const GroundTruth& truth) {
  const Eigen::RowVectorXd mean = points.colwise().mean();
  LinearEquations equations;
  equations.about_mean = true;
  equations.rows = points.rowwise() - mean;
  const double spread = std::sqrt(equations.rows.squaredNorm() / static_cast<double>(equations.rows.rows()));
  if (spread > 0.0) equations.rows /= spread;
  if (truth.model.size() == points.cols() + 1) equations.truth = truth.model.head(points.cols());
  return equations;
}

}  // namespace diffsac
