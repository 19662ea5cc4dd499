#include "diffsac/consensus/chance_ellipsoid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diffsac/geometry/point_spread.h"

namespace diffsac {
namespace {

/// Which share of the unit disc (ball) is on one side of a line (plane) at a signed distance from its centre.
double ShareBelow(double distance, Eigen::Index dimension) {
  const double u = std::clamp(distance, -1.0, 1.0);
  if (dimension == 2) return 0.5 + (u * std::sqrt(1.0 - u * u) + std::asin(u)) / std::numbers::pi;
  return 0.5 + 0.25 * u * (3.0 - u * u);
}

}  // namespace

ChanceEllipsoid::ChanceEllipsoid(const PointMatrix& points, double threshold, double least) : threshold_(threshold) {
  const PointSpread spread = SpreadOf(points);
  const Eigen::VectorXd sigmas = (spread.sides / std::sqrt(12.0)).cwiseMax(threshold);
  const Eigen::MatrixXd whitened =
      (points.rowwise() - spread.centre.transpose()) * spread.axes * sigmas.cwiseInverse().asDiagonal();
  const double reach = points.rows() > 0 ? whitened.rowwise().norm().maxCoeff() : 0.0;
  centre_ = spread.centre;
  axes_ = (reach * sigmas).cwiseMax(least).asDiagonal() * spread.axes.transpose();
}

double ChanceEllipsoid::ShareNear(const ModelParameters& model) const {
  const Eigen::Index dimension = centre_.size();
  const auto normal = model.head(dimension);
  const double reach = (axes_ * normal).norm(), distance = normal.dot(centre_) + model[dimension];
  return ShareBelow((threshold_ - distance) / reach, dimension) -
         ShareBelow((-threshold_ - distance) / reach, dimension);
}

}  // namespace diffsac
