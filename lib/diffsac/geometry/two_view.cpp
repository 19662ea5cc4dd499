#include "diffsac/geometry/two_view.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace diffsac {
namespace {

/// Differences below this share of the coordinates' size are rounding, not geometry.
constexpr double kRoundingShare = 1e-12;
/// Width over length below which a point set is a line.
constexpr double kMinWidth = 1e-9;

/// Whether the points (two columns from `column`) all lie on one line, up to rounding; true when all are equal.
bool AllOnOneLine(const PointMatrix& points, int column) {
  const auto xy = points.middleCols<2>(column);
  const Eigen::RowVector2d origin = xy.row(0);
  Eigen::Index far = 0;
  const double extent = std::sqrt((xy.rowwise() - origin).rowwise().squaredNorm().maxCoeff(&far));
  if (!(extent > kRoundingShare * xy.cwiseAbs().maxCoeff()) || !std::isfinite(extent)) return true;
  const Eigen::RowVector2d axis = (xy.row(far) - origin) / extent;
  double width = 0.0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::RowVector2d offset = xy.row(i) - origin;
    width = std::max(width, std::abs(axis[0] * offset[1] - axis[1] * offset[0]));
  }
  return !(width > kMinWidth * extent);
}

bool HasDistinct(const PointMatrix& points, int count) {
  const double tolerance = kRoundingShare * points.cwiseAbs().maxCoeff();
  std::vector<Eigen::Index> distinct;
  for (Eigen::Index i = 0; i < points.rows() && static_cast<int>(distinct.size()) < count; ++i) {
    const bool seen = std::any_of(distinct.begin(), distinct.end(), [&](Eigen::Index j) {
      return (points.row(i) - points.row(j)).cwiseAbs().maxCoeff() <= tolerance;
    });
    if (!seen) distinct.push_back(i);
  }
  return static_cast<int>(distinct.size()) >= count;
}

}  // namespace

bool MakeNormalization(double x, double y, double mean_square, double largest, ImageNormalization* out) {
  const double distance = std::sqrt(mean_square);
  if (!(distance > kRoundingShare * largest) || !std::isfinite(distance)) return false;
  *out = {x, y, std::sqrt(2.0) / distance};
  return std::isfinite(out->scale) && std::isfinite(x) && std::isfinite(y);
}

bool NormalizeSet(const PointMatrix& points, const int* set, int count, PairNormalization* out) {
  const auto point = [&](int i) { return points.data() + 4 * static_cast<Eigen::Index>(set[i]); };
  double mean[4] = {}, largest[2] = {}, square[2] = {};
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < 4; ++j) {
      mean[j] += point(i)[j] / count;
      largest[j / 2] = std::max(largest[j / 2], std::abs(point(i)[j]));
    }
  }
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < 4; ++j) square[j / 2] += (point(i)[j] - mean[j]) * (point(i)[j] - mean[j]) / count;
  return MakeNormalization(mean[0], mean[1], square[0], largest[0], &out->first) &&
         MakeNormalization(mean[2], mean[3], square[1], largest[1], &out->second);
}

bool DeterminesTwoViews(const PointMatrix& points, int min_distinct) {
  if (points.cols() != 4 || points.rows() < min_distinct || !points.allFinite()) return false;
  return HasDistinct(points, min_distinct) && !AllOnOneLine(points, 0) && !AllOnOneLine(points, 2);
}

}  // namespace diffsac
