#include "diffsac/consensus/local/neighborhood_support.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "diffsac/consensus/samplers/neighbor_index.h"

namespace diffsac {
namespace {

constexpr double kSharedOfRight = 0.5;

}  // namespace

Eigen::VectorXd NeighborhoodSupport(const PointMatrix& matches, int neighbors) {
  Eigen::VectorXd support = Eigen::VectorXd::Zero(matches.rows());
  if (matches.rows() < 2 * neighbors) return support;
  const NeighborIndex first(matches.leftCols(2)), second(matches.rightCols(2));
  const double by_chance = std::min(kSharedOfRight, neighbors / static_cast<double>(matches.rows() - 1));
  const double shared = std::log(kSharedOfRight / by_chance);
  const double other = std::log((1.0 - kSharedOfRight) / (1.0 - by_chance));
  for (int i = 0; i < first.size(); ++i) {
    std::vector<int> here = first.Nearest(i, neighbors), there = second.Nearest(i, neighbors), both;
    std::sort(here.begin(), here.end());
    std::sort(there.begin(), there.end());
    std::set_intersection(here.begin(), here.end(), there.begin(), there.end(), std::back_inserter(both));
    const auto count = static_cast<int>(both.size());
    support[i] = count * shared + (neighbors - count) * other;
  }
  return support;
}

}  // namespace diffsac
