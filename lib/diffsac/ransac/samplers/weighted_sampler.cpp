#include "diffsac/ransac/samplers/weighted_sampler.h"

#include <algorithm>
#include <cmath>

namespace diffsac {
namespace {

/// Redraws of a point that is taken before the rest is gone through one by one.
constexpr int kRedraws = 16;

bool Contains(std::span<const int> taken, int index) {
  return std::find(taken.begin(), taken.end(), index) != taken.end();
}

}  // namespace

WeightedSampler::WeightedSampler(std::span<const double> weights, int set_size, const Rng& rng)
    : set_size_(set_size), rng_(rng), weights_(weights.begin(), weights.end()) {
  double largest = 0.0;
  for (double& weight : weights_) {
    if (!(weight > 0.0) || !std::isfinite(weight)) weight = 0.0;
    largest = std::max(largest, weight);
  }
  double sum = 0.0;
  cumulative_.reserve(weights_.size());
  for (double& weight : weights_) {
    if (largest > 0.0) weight /= largest;
    positive_ += weight > 0.0 ? 1 : 0;
    cumulative_.push_back(sum += weight);
  }
}

int WeightedSampler::DrawOne(std::span<const int> taken, Rng& rng) const {
  for (int i = 0; i < kRedraws; ++i) {
    const double target = rng.Uniform() * cumulative_.back();
    const auto place = std::upper_bound(cumulative_.begin(), cumulative_.end(), target);
    const int index = static_cast<int>(place - cumulative_.begin());
    if (index < static_cast<int>(weights_.size()) && weights_[index] > 0.0 && !Contains(taken, index)) return index;
  }
  return DrawRemaining(taken, rng);
}

int WeightedSampler::DrawRemaining(std::span<const int> taken, Rng& rng) const {
  const bool any_weight = static_cast<int>(taken.size()) < positive_;
  const auto weight = [&](int i) { return any_weight ? weights_[i] : (weights_[i] > 0.0 ? 0.0 : 1.0); };
  const int size = static_cast<int>(weights_.size());
  double total = 0.0;
  for (int i = 0; i < size; ++i) total += Contains(taken, i) ? 0.0 : weight(i);
  double target = rng.Uniform() * total;
  int last = -1;
  for (int i = 0; i < size; ++i) {
    if (!(weight(i) > 0.0) || Contains(taken, i)) continue;
    last = i;
    if ((target -= weight(i)) < 0.0) break;
  }
  return last;
}

bool WeightedSampler::Next(std::span<int> set) {
  if (set_size_ < 1 || weights_.size() < set.size() || static_cast<int>(set.size()) != set_size_) return false;
  Rng draw = DrawRng(rng_, draws_++);
  for (int member = 0; member < set_size_; ++member) {
    const std::span<const int> taken = set.first(member);
    set[member] = member < positive_ ? DrawOne(taken, draw) : DrawRemaining(taken, draw);
  }
  std::sort(set.begin(), set.end());
  return true;
}

}  // namespace diffsac
