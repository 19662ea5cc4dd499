#include "diffsac/estimators/pixel_length.h"

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

double ShareOfExtent(const Eigen::Matrix<double, Eigen::Dynamic, 2>& points) {
  const auto range = [&](int axis) { return Quantile(points.col(axis), 0.75) - Quantile(points.col(axis), 0.25); };
  return 2.0 * std::max(range(0), range(1)) / kPixels;
}

double PixelLength(const Eigen::Matrix<double, Eigen::Dynamic, 2>& points) {
  const double median = Quantile(points.cwiseAbs().rowwise().maxCoeff(), 0.5);
  if (median >= kNearest && median <= kFarthest) return 1.0;
  const double share = ShareOfExtent(points);
  return share > 0.0 ? share : 1.0;
}

double LengthInResiduals(Task task, const Eigen::Matrix<double, Eigen::Dynamic, 2>& points1,
                         const Eigen::Matrix<double, Eigen::Dynamic, 2>& points2,
                         double (*length_of)(const Eigen::Matrix<double, Eigen::Dynamic, 2>&)) {
  const double first = length_of(points1), second = length_of(points2);
  return task == Task::kEssential ? 0.5 * (first + second) : std::min(first, second);
}

}  // namespace diffsac
