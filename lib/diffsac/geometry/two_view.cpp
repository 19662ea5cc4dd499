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

bool SetScale(double mean_distance, double largest, ImageNormalization* out) {
  if (!(mean_distance > kRoundingShare * largest) || !std::isfinite(mean_distance)) return false;
  out->scale = std::sqrt(2.0) / mean_distance;
  return std::isfinite(out->scale) && std::isfinite(out->x) && std::isfinite(out->y);
}

/// Means and mean distances over an enumeration of (row, weight).
template <class ForEach>
bool Normalize(const ForEach& for_each, double total, PairNormalization* out) {
  double mean[4] = {0.0, 0.0, 0.0, 0.0}, largest[2] = {0.0, 0.0};
  for_each([&](const double* p, double weight) {
    for (int i = 0; i < 4; ++i) {
      mean[i] += weight * p[i];
      largest[i / 2] = std::max(largest[i / 2], std::abs(p[i]));
    }
  });
  for (double& value : mean) value /= total;
  double distance[2] = {0.0, 0.0};
  for_each([&](const double* p, double weight) {
    for (int image = 0; image < 2; ++image) {
      const double dx = p[2 * image] - mean[2 * image], dy = p[2 * image + 1] - mean[2 * image + 1];
      distance[image] += weight * std::sqrt(dx * dx + dy * dy);
    }
  });
  out->first = {mean[0], mean[1], 1.0};
  out->second = {mean[2], mean[3], 1.0};
  return SetScale(distance[0] / total, largest[0], &out->first) &&
         SetScale(distance[1] / total, largest[1], &out->second);
}

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

bool NormalizeSet(const PointMatrix& points, const int* set, int count, PairNormalization* out) {
  return Normalize(
      [&](const auto& add) {
        for (int i = 0; i < count; ++i) add(points.data() + 4 * static_cast<Eigen::Index>(set[i]), 1.0);
      },
      count, out);
}

bool NormalizeWeighted(const PointMatrix& points, const Eigen::VectorXd& weights, int min_positive,
                       PairNormalization* out) {
  if (points.cols() != 4 || weights.size() != points.rows()) return false;
  double total = 0.0;
  int positive = 0;
  for (const double weight : weights) {
    if (!(weight >= 0.0)) return false;
    total += weight;
    positive += weight > 0.0 ? 1 : 0;
  }
  if (positive < min_positive || !(total > 0.0) || !std::isfinite(total)) return false;
  return Normalize(
      [&](const auto& add) {
        for (Eigen::Index i = 0; i < points.rows(); ++i)
          if (weights[i] > 0.0) add(points.data() + 4 * i, weights[i]);
      },
      total, out);
}

bool DeterminesTwoViews(const PointMatrix& points, int min_distinct) {
  if (points.cols() != 4 || points.rows() < min_distinct || !points.allFinite()) return false;
  return HasDistinct(points, min_distinct) && !AllOnOneLine(points, 0) && !AllOnOneLine(points, 2);
}

}  // namespace diffsac
