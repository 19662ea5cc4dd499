#include "diffsac/problem/chance_share.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diffsac/geometry/point_spread.h"

namespace diffsac {
namespace {

double Share(double part, double whole) { return whole > 0.0 ? std::min(1.0, part / whole) : 1.0; }

Eigen::VectorXd BoxOf(const PointMatrix& points) {
  if (points.rows() == 0) return Eigen::VectorXd::Zero(points.cols());
  return (points.colwise().maxCoeff() - points.colwise().minCoeff()).transpose();
}

}  // namespace

Eigen::Vector2d ImageExtent(const ImageSize& size, const PointMatrix& image_points) {
  if (size.known()) return {size.width, size.height};
  return BoxOf(image_points);
}

double EpipolarBandShare(const Eigen::Vector2d& extent, double threshold) {
  // An epipolar distance is √2 times the Sampson distance, both images alike.
  return Share(2.0 * std::numbers::sqrt2 * threshold * extent.norm(), extent.prod());
}

double DiscShare(const Eigen::Vector2d& extent, double threshold) {
  return Share(std::numbers::pi * threshold * threshold, extent.prod());
}

double SlabShare(const PointMatrix& points, double threshold) {
  if (points.rows() == 0) return 1.0;
  const auto dimension = static_cast<double>(points.cols());
  const double side = SpreadOf(points).sides.maxCoeff();
  // No section of a cube is larger than √d of its faces (a square's diagonal).
  return Share(2.0 * threshold * std::sqrt(dimension) * std::pow(side, dimension - 1.0), std::pow(side, dimension));
}

}  // namespace diffsac
