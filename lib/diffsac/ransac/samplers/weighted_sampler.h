#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac {

/// Sets whose points are drawn one after the other in proportion to given weights, without replacement within a set.
/// A weight that is not positive and finite counts as 0. Such points are drawn, uniformly, only where fewer than γ
/// points have a weight; all weights 0 is uniform sampling. A draw costs O(γ log N).
class WeightedSampler : public MinimalSampler {
 public:
  /// weights: one number a point, copied.
  WeightedSampler(std::span<const double> weights, int set_size, const Rng& rng);
  bool Next(std::span<int> set) override;

 private:
  int DrawOne(std::span<const int> taken, Rng& rng) const;
  int DrawRemaining(std::span<const int> taken, Rng& rng) const;

  int set_size_;
  Rng rng_;
  std::int64_t draws_ = 0;
  std::vector<double> weights_;     ///< Scaled so that the largest is 1.
  std::vector<double> cumulative_;  ///< Sums of the weights up to and with each point.
  int positive_ = 0;                ///< Points with a weight.
};

}  // namespace diffsac
