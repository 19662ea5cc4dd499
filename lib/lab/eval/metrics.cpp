#include "lab/eval/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "diffsac/problem/tasks.h"
#include "lab/eval/instances_error.h"
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

double ShownError(const EstimateError& error, const Tolerance& tolerance) {
  return std::isnan(error.misclassified) ? MainError(error, tolerance) : error.misclassified;
}

const char* ShownUnit(bool instances, const Tolerance& tolerance) {
  return instances ? "%" : tolerance.pixels ? "px" : "°";
}

double AverageAccuracy(double error, double threshold) {
  int accurate = 0;
  for (int k = 1; k <= kBins; ++k) accurate += error <= k * threshold / kBins;
  return static_cast<double>(accurate) / kBins;
}

double MeanAverageAccuracy(std::span<const double> errors, double threshold) {
  if (errors.empty()) return kNaN;
  double sum = 0.0;
  for (const double error : errors) sum += AverageAccuracy(error, threshold);
  return sum / static_cast<double>(errors.size());
}

double AreaUnderCurve(std::span<const double> errors, double threshold) {
  if (errors.empty()) return kNaN;
  std::vector<double> sorted;
  for (const double error : errors)
    if (error < threshold) sorted.push_back(error);
  std::sort(sorted.begin(), sorted.end());
  double area = 0.0, last_error = 0.0, last_recall = 0.0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double recall = static_cast<double>(i + 1) / static_cast<double>(errors.size());
    area += (sorted[i] - last_error) * (recall + last_recall) / 2.0;
    last_error = sorted[i];
    last_recall = recall;
  }
  return (area + (threshold - last_error) * last_recall) / threshold;
}

double RecallArea(std::span<const double> errors, double threshold) {
  if (errors.empty()) return kNaN;
  std::vector<double> sorted(errors.begin(), errors.end());
  std::sort(sorted.begin(), sorted.end());
  const auto recall = [&](std::size_t i) { return static_cast<double>(i + 1) / static_cast<double>(sorted.size()); };
  const auto below =
      static_cast<std::size_t>(std::lower_bound(sorted.begin(), sorted.end(), threshold) - sorted.begin());
  if (below == 0) return 0.0;
  double area = 0.0;
  for (std::size_t i = 1; i < below; ++i) area += 0.5 * (sorted[i] - sorted[i - 1]) * (recall(i) + recall(i - 1));
  const double last = sorted[below - 1];
  double at_threshold = 1.0;
  if (below < sorted.size()) {
    const double next = sorted[below];
    at_threshold = next > threshold ? (last * recall(below - 1) + next * recall(below)) / (last + next) : recall(below);
  }
  area += 0.5 * (threshold - last) * (recall(below - 1) + at_threshold);
  return area / threshold;
}

double AccuracyWithin(std::span<const double> errors, double threshold) {
  if (errors.empty()) return kNaN;
  const auto within = std::count_if(errors.begin(), errors.end(), [&](double error) { return error <= threshold; });
  return static_cast<double>(within) / static_cast<double>(errors.size());
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
