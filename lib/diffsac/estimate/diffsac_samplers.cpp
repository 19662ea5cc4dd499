#include "diffsac/estimate/diffsac_samplers.h"

#include <algorithm>
#include <cmath>

namespace diffsac {
namespace {

// Keeps the logarithm of a probability finite.
constexpr float kLeastProbability = 1e-12f;
// The logarithm of the smallest weight beside 1: whatever the temperature, every point can be drawn.
constexpr double kLeastLogWeight = -700.0;

// The temperature on rung k of `count`.
double Rung(const Range& temperature, int k, int count) {
  const double share = count > 1 ? static_cast<double>(k) / (count - 1) : 0.0;
  return temperature.low * std::pow(temperature.high / temperature.low, share);
}

}  // namespace

void ScaleConfidences(std::span<float> confidences, int copies, Range temperature, bool probabilities) {
  if (probabilities)
    for (float& key : confidences) key = std::log(std::max(0.5f * (1.0f + key), kLeastProbability));
  const std::size_t points = confidences.size() / static_cast<std::size_t>(copies);
  for (int k = 0; k < copies; ++k) {
    const auto inverse = static_cast<float>(1.0 / Rung(temperature, k, copies));
    for (float& key : confidences.subspan(static_cast<std::size_t>(k) * points, points)) key *= inverse;
  }
}

TemperedSampler::TemperedSampler(std::span<const float> probabilities, int set_size, Range temperature,
                                 const Rng& rng) {
  std::vector<double> logs;
  for (const float p : probabilities) logs.push_back(std::log(std::max<double>(p, kLeastProbability)));
  const double largest = logs.empty() ? 0.0 : *std::max_element(logs.begin(), logs.end());
  const int rungs = temperature.low == temperature.high ? 1 : kRungs;
  std::vector<double> weights(logs.size());
  for (int r = 0; r < rungs; ++r) {
    const double inverse = 1.0 / Rung(temperature, r, rungs);
    for (std::size_t i = 0; i < logs.size(); ++i)
      weights[i] = std::exp(std::max((logs[i] - largest) * inverse, kLeastLogWeight));
    rungs_.emplace_back(weights, set_size, rng.Fork("rung", static_cast<std::uint64_t>(r)));
  }
}

bool TemperedSampler::Next(std::span<int> set) { return rungs_[next_++ % rungs_.size()].Next(set); }

}  // namespace diffsac
