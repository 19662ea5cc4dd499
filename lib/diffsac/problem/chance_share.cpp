#include "diffsac/problem/chance_share.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "diffsac/geometry/point_spread.h"
#include "diffsac/problem/cloud_chance.h"

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

double OccupiedShare(const PointMatrix& cloud, double threshold) {
  const Eigen::Index count = cloud.rows();
  if (count < 2) return 1.0;
  const BallGrid grid(cloud, cloud, threshold);
  if (!(grid.side() > 0.0)) return 1.0;
  std::vector<std::uint64_t> cells(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < count; ++i) cells[i] = grid.CellOf(cloud, i);
  std::sort(cells.begin(), cells.end());
  // Pairs of points, and of these in one cell at least one.
  const double pairs = 0.5 * static_cast<double>(count) * static_cast<double>(count - 1);
  double together = 0.0, before = 0.0;
  for (std::size_t i = 1; i < cells.size(); ++i) {
    before = cells[i] == cells[i - 1] ? before + 1.0 : 0.0;
    together += before;
  }
  return Share(std::max(together, 1.0), pairs);
}

}  // namespace diffsac
