#include "diffsac/problem/cloud_chance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/rigid.h"
#include "diffsac/ransac/scores/number_of_false_alarms.h"

namespace diffsac {
namespace {

using Cell = std::uint64_t;
using Cells = std::vector<Cell>;

int CountDistinct(Cells cells) {
  std::sort(cells.begin(), cells.end());
  return static_cast<int>(std::unique(cells.begin(), cells.end()) - cells.begin());
}

/// How often a cell of the one, which are in order, is that of the other, of all pairs.
double ShareTogether(const Cells& first, Cells second) {
  std::sort(second.begin(), second.end());
  double together = 0.0;
  auto j = second.begin();
  for (auto i = first.begin(); i != first.end();) {
    const auto next = std::upper_bound(i, first.end(), *i);
    j = std::lower_bound(j, second.end(), *i);
    const auto last = std::upper_bound(j, second.end(), *i);
    together += static_cast<double>(next - i) * static_cast<double>(last - j);
    i = next;
    j = last;
  }
  return std::max(together, 1.0) / (static_cast<double>(first.size()) * static_cast<double>(second.size()));
}

}  // namespace

BallGrid::BallGrid(const PointMatrix& first, const PointMatrix& second, double threshold)
    : least_(first.colwise().minCoeff().cwiseMin(second.colwise().minCoeff())) {
  const double extent = (first.colwise().maxCoeff().cwiseMax(second.colwise().maxCoeff()) - least_).maxCoeff();
  side_ = std::max(std::cbrt(4.0 / 3.0 * std::numbers::pi) * threshold, extent / kMostCells);
}

std::uint64_t BallGrid::CellOf(const PointMatrix& points, Eigen::Index row) const {
  std::uint64_t cell = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = (points(row, axis) - least_[axis]) / side_;
    cell = cell << 21U | (place >= 0.0 && place <= kMostCells ? static_cast<std::uint64_t>(place) : 0);  // Not NaN.
  }
  return cell;
}

double LogChanceMotions(const PointMatrix& points, const ModelParameters& model,
                        const std::vector<std::uint8_t>& inliers, double threshold) {
  const Similarity::Parameters motion = model;
  const PointMatrix moved =
      (points.leftCols(3) * RotationOf(motion).transpose()).rowwise() + TranslationOf(motion).transpose();
  const PointMatrix second = points.rightCols(3);
  const BallGrid grid(moved, second, threshold);
  std::vector<std::pair<Cell, Cell>> pairs;
  pairs.reserve(static_cast<std::size_t>(points.rows()));
  Cells firsts, seconds;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    pairs.emplace_back(grid.CellOf(moved, i), grid.CellOf(second, i));
    if (inliers[static_cast<std::size_t>(i)] != 1) continue;
    firsts.push_back(pairs.back().first);
    seconds.push_back(pairs.back().second);
  }
  const int witnesses = std::min(CountDistinct(std::move(firsts)), CountDistinct(std::move(seconds)));
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  firsts.clear();
  seconds.clear();
  for (const auto& [one, other] : pairs) {
    firsts.push_back(one);
    seconds.push_back(other);
  }
  const auto count = static_cast<int>(pairs.size());
  return LogChanceModels(count, witnesses, Similarity::kMinimalSize, ShareTogether(firsts, std::move(seconds)));
}

}  // namespace diffsac
