#include "diffsac/problem/good_neighbors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace diffsac {
namespace {

constexpr int kFewestGood = 16;

// Rows of the matches of lowest ratio, ascending.
std::vector<std::int32_t> GoodMatches(std::int32_t count, const Eigen::VectorXd& quality) {
  const bool known = quality.size() == count;
  std::vector<std::pair<double, std::int32_t>> ranked(count);
  for (std::int32_t i = 0; i < count; ++i) {
    const double ratio = known ? quality[i] : 0.0;
    // NaN ranks last.
    ranked[i] = {std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio, i};
  }
  const std::int32_t kept = known ? std::min(count, std::max(kFewestGood, count / 4)) : count;
  if (kept < count) std::nth_element(ranked.begin(), ranked.begin() + kept, ranked.end());
  std::vector<std::int32_t> good(kept);
  for (std::int32_t i = 0; i < kept; ++i) good[i] = ranked[i].second;
  std::sort(good.begin(), good.end());
  return good;
}

}  // namespace

PlanePoints ImagePlane(const PointMatrix& coordinates, int image) {
  PlanePoints plane(coordinates.rows());
  for (Eigen::Index i = 0; i < coordinates.rows(); ++i) {
    plane.x[i] = coordinates(i, 2 * image);
    plane.y[i] = coordinates(i, 2 * image + 1);
  }
  return plane;
}

PlanePoints RowsOf(const PlanePoints& plane, const std::vector<std::int32_t>& rows) {
  PlanePoints chosen(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) chosen.x[i] = plane.x[rows[i]], chosen.y[i] = plane.y[rows[i]];
  return chosen;
}

GoodNeighbors FindGoodNeighbors(const PointMatrix& coordinates, const Eigen::VectorXd& quality) {
  const auto count = static_cast<std::int32_t>(coordinates.rows());
  GoodNeighbors found{GoodMatches(count, quality), std::vector<std::int32_t>(count, -1)};
  for (std::size_t i = 0; i < found.good.size(); ++i) found.own[found.good[i]] = static_cast<std::int32_t>(i);
  if (count <= kEight) return found;
  for (int image = 0; image < 2; ++image) {
    const PlanePoints plane = ImagePlane(coordinates, image);
    found.nearest[image] = NearestEight(RowsOf(plane, found.good), plane, found.own);
  }
  return found;
}

}  // namespace diffsac
