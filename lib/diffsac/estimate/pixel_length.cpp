#include "diffsac/estimate/pixel_length.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

constexpr double kNearest = 20.0, kFarthest = 2e4, kPixels = 1000.0;

}  // namespace

double Quantile(const Eigen::VectorXd& column, double share) {
  std::vector<double> values(column.data(), column.data() + column.size());
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return 0.0;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

double ShareOfExtent(const Points2DView& points) {
  const auto range = [&](int axis) {
    return Quantile(points.matrix().col(axis), 0.75) - Quantile(points.matrix().col(axis), 0.25);
  };
  return 2.0 * std::max(range(0), range(1)) / kPixels;
}

double PixelLength(const Points2DView& points) {
  const double median = Quantile(points.matrix().cwiseAbs().rowwise().maxCoeff(), 0.5);
  if (median >= kNearest && median <= kFarthest) return 1.0;
  const double share = ShareOfExtent(points);
  return share > 0.0 ? share : 1.0;
}

double LengthInResiduals(Task task, const Points2DView& points1, const Points2DView& points2,
                         double (*length_of)(const Points2DView&)) {
  const double first = length_of(points1), second = length_of(points2);
  return task == Task::kEssential ? 0.5 * (first + second) : std::min(first, second);
}

}  // namespace diffsac
