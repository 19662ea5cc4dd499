#pragma once

#include <span>
#include <vector>

#include "diffsac/consensus/hypothesis_source.h"

namespace diffsac {

/// Sets whose points are drawn one after the other in proportion to given weights, without replacement within a set.
/// A weight that is not positive and finite counts as 0. Such points are drawn, uniformly, only where fewer than γ
/// points have a weight; all weights 0 is uniform sampling.
class WeightedSource : public HypothesisSource {
 public:
  explicit WeightedSource(std::span<const double> weights);
  int DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                std::vector<int>* sets) const override;

 private:
  int DrawOne(std::span<const int> taken, Rng& rng) const;
  int DrawRemaining(std::span<const int> taken, Rng& rng) const;

  std::vector<double> weights_;     ///< Scaled so that the largest is 1.
  std::vector<double> cumulative_;  ///< Sums of the weights up to and with each point.
  int positive_ = 0;                ///< Points with a weight.
};

}  // namespace diffsac
