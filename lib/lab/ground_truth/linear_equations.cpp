#include "lab/ground_truth/linear_equations.h"

#include <Eigen/LU>
#include <cmath>

#include "diffsac/problem/two_view_task.h"

namespace diffsac {
namespace {

// Centroid to the origin, root mean square distance to √2.
Eigen::Matrix3d Normalization(const PointMatrix& points, int first) {
  const Eigen::RowVector2d mean = points.middleCols(first, 2).colwise().mean();
  const double spread =
      std::sqrt((points.middleCols(first, 2).rowwise() - mean).squaredNorm() / static_cast<double>(points.rows()));
  const double scale = spread > 0.0 ? std::sqrt(2.0) / spread : 1.0;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 0) = matrix(1, 1) = scale;
  matrix(0, 2) = -scale * mean.x();
  matrix(1, 2) = -scale * mean.y();
  return matrix;
}

// Both images' points in these coordinates, one match at a time.
struct NormalizedMatches {
  Eigen::Matrix3d first, second;
  explicit NormalizedMatches(const PointMatrix& points)
      : first(Normalization(points, 0)), second(Normalization(points, 2)) {}
  Eigen::Vector3d First(const PointMatrix& points, Eigen::Index i) const {
    return first * Eigen::Vector3d(points(i, 0), points(i, 1), 1.0);
  }
  Eigen::Vector3d Second(const PointMatrix& points, Eigen::Index i) const {
    return second * Eigen::Vector3d(points(i, 2), points(i, 3), 1.0);
  }
};

}  // namespace

LinearEquations HyperplaneEquations(const NormalizedProblem& space, const GroundTruth& truth) {
  const PointMatrix& points = space.points();
  const Eigen::RowVectorXd mean = points.colwise().mean();
  LinearEquations equations;
  equations.about_mean = true;
  equations.rows = points.rowwise() - mean;
  const double spread = std::sqrt(equations.rows.squaredNorm() / static_cast<double>(equations.rows.rows()));
  if (spread > 0.0) equations.rows /= spread;
  if (truth.model.size() == points.cols() + 1) equations.truth = truth.model.head(points.cols());
  return equations;
}

LinearEquations HomographyEquations(const NormalizedProblem& space, const GroundTruth& truth) {
  const PointMatrix& points = space.points();
  const NormalizedMatches normalized(points);
  LinearEquations equations;
  equations.rows_per_point = 2;
  equations.rows = PointMatrix::Zero(2 * points.rows(), 9);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d a = normalized.First(points, i), b = normalized.Second(points, i);
    equations.rows.row(2 * i) << 0.0, 0.0, 0.0, -a.transpose(), b.y() * a.transpose();
    equations.rows.row(2 * i + 1) << a.transpose(), 0.0, 0.0, 0.0, -b.x() * a.transpose();
  }
  if (truth.model.size() == 9)
    equations.truth =
        AsParameters(Eigen::Matrix3d(normalized.second * ModelMatrix(truth.model) * normalized.first.inverse()));
  return equations;
}

LinearEquations EpipolarEquations(const NormalizedProblem& space, const GroundTruth& truth) {
  const PointMatrix& points = space.points();
  const NormalizedMatches normalized(points);
  LinearEquations equations;
  equations.rows = PointMatrix::Zero(points.rows(), 9);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d a = normalized.First(points, i), b = normalized.Second(points, i);
    equations.rows.row(i) << b.x() * a.transpose(), b.y() * a.transpose(), a.transpose();
  }
  if (truth.model.size() == 9)
    equations.truth = AsParameters(Eigen::Matrix3d(normalized.second.inverse().transpose() * ModelMatrix(truth.model) *
                                                   normalized.first.inverse()));
  return equations;
}

}  // namespace diffsac
