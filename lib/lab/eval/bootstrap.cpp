#include "lab/eval/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "lab/eval/metrics.h"

namespace diffsac {
namespace {

double MeanOfMeans(const SceneValues& values) {
  double sum = 0.0;
  for (const auto& scene : values) sum += Mean(scene);
  return sum / static_cast<double>(values.size());
}

double RedrawnMean(const SceneValues& values, Rng& rng) {
  double sum = 0.0;
  for (const auto& scene : values) {
    double scene_sum = 0.0;
    for (std::size_t i = 0; i < scene.size(); ++i) scene_sum += scene[rng.Below(scene.size())];
    sum += scene_sum / static_cast<double>(scene.size());
  }
  return sum / static_cast<double>(values.size());
}

/// Linear interpolation between order statistics.
double Quantile(const std::vector<double>& sorted, double q) {
  const double at = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(at));
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

ConfidenceInterval BootstrapMean(const SceneValues& values, Rng rng, int rounds, double level) {
  const bool empty = values.empty() || std::any_of(values.begin(), values.end(), [](auto& s) { return s.empty(); });
  if (empty || rounds < 1) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {empty ? nan : MeanOfMeans(values), nan, nan};
  }
  std::vector<double> means;
  for (int i = 0; i < rounds; ++i) means.push_back(RedrawnMean(values, rng));
  std::sort(means.begin(), means.end());
  return {MeanOfMeans(values), Quantile(means, (1.0 - level) / 2.0), Quantile(means, (1.0 + level) / 2.0)};
}

ConfidenceInterval BootstrapDifference(const SceneValues& a, const SceneValues& b, Rng rng, int rounds, double level) {
  SceneValues difference = a;
  bool same = a.size() == b.size();
  for (std::size_t s = 0; same && s < a.size(); ++s) same = a[s].size() == b[s].size();
  if (!same) throw std::invalid_argument("a paired bootstrap needs the same problems for both methods");
  for (std::size_t s = 0; s < a.size(); ++s)
    for (std::size_t i = 0; i < a[s].size(); ++i) difference[s][i] -= b[s][i];
  return BootstrapMean(difference, rng, rounds, level);
}

}  // namespace diffsac
