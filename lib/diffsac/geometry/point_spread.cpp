#include "diffsac/geometry/point_spread.h"

#include <Eigen/Eigenvalues>

namespace diffsac {

PointSpread SpreadOf(const PointMatrix& points) {
  const Eigen::Index dimension = points.cols();
  PointSpread spread{Eigen::VectorXd::Zero(dimension), Eigen::MatrixXd::Identity(dimension, dimension),
                     Eigen::VectorXd::Zero(dimension)};
  if (points.rows() == 0) return spread;
  spread.centre = points.colwise().mean().transpose();
  const PointMatrix offsets = points.rowwise() - spread.centre.transpose();
  // Squares of any length stay ordinary numbers.
  const double reach = offsets.rowwise().norm().maxCoeff();
  if (!(reach > 0.0)) return spread;
  const Eigen::MatrixXd scaled = offsets / reach;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled.transpose() * scaled /
                                                              static_cast<double>(points.rows()));
  spread.axes = solver.eigenvectors();
  spread.sides = reach * (12.0 * solver.eigenvalues().array().max(0.0)).sqrt();
  return spread;
}

}  // namespace diffsac
