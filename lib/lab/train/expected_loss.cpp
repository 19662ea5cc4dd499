#include "lab/train/expected_loss.h"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "diffsac/problem/normalized_problem.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

// Keeps the logarithm of what is left to draw from finite.
constexpr double kLeastRemainder = 1e-6;

template <MinimalModel Model>
std::vector<double> DistancesOf(const Example& example) {
  using Parameters = typename Model::Parameters;
  const NormalizedProblem space(example.problem);
  std::vector<ModelParameters> models = example.truth.instances;
  if (models.empty()) models.push_back(example.truth.model);
  std::vector<double> distances;
  for (const ModelParameters& parameters : models) {
    if (parameters.size() != Parameters::SizeAtCompileTime || !parameters.allFinite()) return {};
    const Parameters model = parameters;
    distances.resize(static_cast<std::size_t>(space.points().rows()), std::numeric_limits<double>::infinity());
    for (Eigen::Index i = 0; i < space.points().rows(); ++i) {
      const double distance = Model::Residual(model, space.points().row(i).data()) / space.threshold();
      distances[i] = std::isfinite(distance) ? std::min(distances[i], distance) : distances[i];
    }
  }
  return distances;
}

}  // namespace

std::vector<double> TruthDistances(const Example& example) {
  return DispatchTask(example.problem.task, [&]<class Model>() { return DistancesOf<Model>(example); });
}

std::vector<float> TargetDistribution(const Example& example, double sigma) {
  const auto count = static_cast<std::size_t>(example.problem.points.rows());
  const auto distances = TruthDistances(example);
  std::vector<float> target(count, 0.0f);
  for (std::size_t i = 0; i < count; ++i) {
    if (distances.size() == count) {
      const double r = distances[i] / sigma;
      target[i] = std::isfinite(r) ? static_cast<float>(std::exp(-0.5 * r * r)) : 0.0f;
    } else if (example.truth.inliers.size() == count) {
      target[i] = example.truth.inliers[i];
    }
  }
  float sum = std::accumulate(target.begin(), target.end(), 0.0f);
  if (!(sum > 0.0f)) {
    std::fill(target.begin(), target.end(), 1.0f);
    sum = static_cast<float>(count);
  }
  for (float& value : target) value /= sum;
  return target;
}

torch::Tensor TargetDivergence(const torch::Tensor& log_weights, const torch::Tensor& target) {
  const auto cross = target * (target.clamp_min(1e-30).log() - log_weights.clamp_min(-1e4));
  return cross.sum(1).mean();
}

std::vector<int> DrawOrderedSets(std::span<const float> log_weights, int set_size, int count, Rng rng) {
  const int points = static_cast<int>(log_weights.size());
  std::vector<int> sets;
  if (set_size > points) return sets;
  std::vector<std::pair<double, int>> keys(log_weights.size());
  for (int s = 0; s < count; ++s) {
    for (int i = 0; i < points; ++i) {
      const double exponential = -std::log1p(-rng.Uniform());
      keys[i] = {log_weights[i] - std::log(std::max(exponential, 1e-300)), i};
    }
    std::partial_sort(keys.begin(), keys.begin() + set_size, keys.end(), std::greater<>());
    for (int m = 0; m < set_size; ++m) sets.push_back(keys[m].second);
  }
  return sets;
}

torch::Tensor OrderedSetLogProbability(const torch::Tensor& log_weights, const torch::Tensor& sets) {
  const auto chosen = log_weights.gather(1, sets.flatten(1)).view(sets.sizes());  // [B, S, γ]
  const auto before = chosen.exp().cumsum(-1) - chosen.exp();
  return (chosen - (1.0 - before).clamp_min(kLeastRemainder).log()).sum(-1);
}

torch::Tensor ExpectedLossSurrogate(const torch::Tensor& log_probability, const torch::Tensor& losses) {
  const auto draws = static_cast<double>(losses.size(1));
  const auto advantage = (losses - losses.mean(1, true)) * (draws / (draws - 1.0));
  return (advantage.detach() * log_probability).mean();
}

}  // namespace diffsac
