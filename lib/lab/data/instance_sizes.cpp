#include "lab/data/instance_sizes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/generator.h"
#include "lab/data/virtual_views.h"

namespace diffsac {
namespace {

constexpr int kMostInstances = 20;

std::vector<double> DrawWeights(const InstanceOptions& options, int count, Rng rng) {
  const double ratio = LogUniform(options.size_ratio, rng);
  std::vector<double> weights(count, 1.0);
  weights[0] = ratio;
  for (int k = 1; k + 1 < count; ++k) weights[k] = LogUniform({1.0, ratio}, rng);
  std::sort(weights.begin(), weights.end(), std::greater<>());
  return weights;
}

std::vector<int> ShareOut(const std::vector<double>& weights, int inliers, int fewest) {
  const auto count = static_cast<int>(weights.size());
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  // Rounding the running sums keeps the total.
  std::vector<int> sizes(count);
  double before = 0.0;
  int given = 0;
  for (int k = 0; k < count; ++k) {
    before += weights[k];
    const int until = k + 1 == count ? inliers : static_cast<int>(std::lround(inliers * before / sum));
    sizes[k] = until - given;
    given = until;
  }
  for (;;) {
    std::sort(sizes.begin(), sizes.end(), std::greater<>());
    if (sizes.back() >= fewest) return sizes;
    --sizes.front();
    ++sizes.back();
  }
}

}  // namespace

void InstanceOptions::Bind(OptionsBinder& b) {
  b.Field("structures", instances, Within(1, kMostInstances)).Help("how many models are true at once");
  b.Field("size_ratio", size_ratio, Within(1.0, 100.0))
      .Help("points of the largest structure over those of the smallest, log-uniform; the others are between");
  b.Require(IsWhole(instances), "structures", "whole numbers");
}

int FewestOfInstance(Task task) { return MinimalSetSize(task) + 2; }

void CheckInstances(const InstanceOptions& options, Task task, double fewest_points) {
  const int least = static_cast<int>(options.instances.high) * FewestOfInstance(task);
  if (fewest_points < least)
    throw Error("num_points: expected at least " + std::to_string(least) + ", " +
                std::to_string(FewestOfInstance(task)) + " for each of up to " +
                std::to_string(static_cast<int>(options.instances.high)) + " structures of the task " + ToString(task));
}

std::vector<int> DrawInstanceSizes(const InstanceOptions& options, int count, int inliers, int fewest, Rng rng) {
  return ShareOut(DrawWeights(options, count, rng), inliers, fewest);
}

void ArrangeInstances(int fewest, GroundTruth* truth) {
  const auto count = static_cast<int>(truth->instances.size());
  std::vector<int> sizes(count, 0), order(count);
  for (const std::int32_t label : truth->assignment)
    if (label > 0) ++sizes.at(label - 1);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return sizes[a] > sizes[b]; });
  std::vector<std::int32_t> renumbered(count, 0);
  std::vector<ModelParameters> arranged;
  for (const int k : order) {
    if (sizes[k] < fewest) break;
    arranged.push_back(truth->instances[k]);
    renumbered[k] = static_cast<std::int32_t>(arranged.size());
  }
  truth->inliers.clear();
  for (std::int32_t& label : truth->assignment) {
    label = label > 0 ? renumbered[label - 1] : 0;
    truth->inliers.push_back(label > 0);
  }
  truth->model = arranged.empty() ? ModelParameters() : arranged.front();
  truth->instances = std::move(arranged);
}

}  // namespace diffsac
