#include "lab/eval/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "diffsac/problem/tasks.h"
#include "lab/ground_truth/instances_error.h"
#include "lab/ground_truth/task_truth.h"

namespace diffsac {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kBins = 10;

}  // namespace

EstimateError MeasureError(const Estimate& estimate, const Example& example) {
  const int size =
      DispatchTask(example.problem.task, []<class Model>() { return int{Model::Parameters::SizeAtCompileTime}; });
  const bool found = estimate.status == Status::kOk && estimate.model.allFinite() && estimate.model.size() == size;
  EstimateError error =
      TruthOf(example.problem.task).error(found ? &estimate.model : nullptr, estimate.inliers, example);
  AddInstancesError(estimate, example, &error);
  return error;
}

double MainError(const EstimateError& error, const Tolerance& tolerance) {
  return tolerance.pixels ? error.error_px : error.angle_deg;
}

double AverageAccuracyWithin(double error, const Tolerance& tolerance) {
  if (!tolerance.pixels) return AverageAccuracy(error, tolerance.value);
  int accurate = 0;
  for (int k = 0; k < kBins; ++k) accurate += error <= std::pow(tolerance.value, static_cast<double>(k) / (kBins - 1));
  return static_cast<double>(accurate) / kBins;
}

double AccuracyOf(const EstimateError& error, const Tolerance& tolerance) {
  if (!std::isnan(error.recall)) return error.recall;
  const double main = MainError(error, tolerance);
  return std::isnan(main) ? main : AverageAccuracyWithin(main, tolerance);
}

double AverageAccuracy(double error, double threshold) {
  int accurate = 0;
  for (int k = 1; k <= kBins; ++k) accurate += error <= k * threshold / kBins;
  return static_cast<double>(accurate) / kBins;
}

double Median(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return kNaN;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2.0;
}

double Mean(std::span<const double> values) {
  if (values.empty()) return kNaN;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace diffsac
