#include "diffsac/estimators/pixel_length.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace diffsac {
namespace {

constexpr double kNearest = 20.0, kFarthest = 2e4, kPixels = 1000.0;

/// The value that so large a share is below.
double Quantile(std::vector<double> values, double share) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace

double PixelLength(const Eigen::Matrix<double, Eigen::Dynamic, 2>& points) {
  std::vector<double> x, y, larger;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!points.row(i).allFinite()) continue;
    x.push_back(points(i, 0));
    y.push_back(points(i, 1));
    larger.push_back(points.row(i).cwiseAbs().maxCoeff());
  }
  if (larger.empty()) return 1.0;
  const double median = Quantile(larger, 0.5);
  if (median >= kNearest && median <= kFarthest) return 1.0;
  const auto range = [](const std::vector<double>& values) { return Quantile(values, 0.75) - Quantile(values, 0.25); };
  const double reach = 2.0 * std::max(range(x), range(y));
  return reach > 0.0 ? reach / kPixels : 1.0;
}

}  // namespace diffsac
