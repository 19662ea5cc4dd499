#pragma once

#include <memory>
#include <span>
#include <vector>

#include "diffsac/core/range.h"
#include "diffsac/ransac/samplers/confidence_sampler.h"
#include "diffsac/ransac/samplers/weighted_sampler.h"

namespace diffsac {

/// ConfidenceSampler over confidences that it owns.
class CopiesSampler : public MinimalSampler {
 public:
  CopiesSampler(std::vector<float> confidences, int num_points, int set_size, Selection selection, bool unique,
                const Rng& rng)
      : confidences_(std::move(confidences)),
        sampler_(confidences_, num_points, set_size, selection, unique, 1.0, rng) {}
  bool Next(std::span<int> set) override { return sampler_.Next(set); }

 private:
  std::vector<float> confidences_;
  ConfidenceSampler sampler_;
};

/// κ rows of confidences in [−1, 1] (and, behind them, earlier predictions') as keys of Gumbel top-γ draws in
/// proportion to p^(1/T), p = (1 + c)/2, or without `probabilities` to exp(c/T): row k of each κ is divided by its
/// temperature on the ladder from the first to the last.
void ScaleConfidences(std::span<float> confidences, int copies, Range temperature, bool probabilities);

/// Sets drawn in proportion to p^(1/T) for fixed probabilities p. T goes through kRungs temperatures, in equal ratios
/// from the first to the last, again and again: draw i takes rung i mod kRungs, at O(γ log N) a draw.
class TemperedSampler : public MinimalSampler {
 public:
  static constexpr int kRungs = 10;
  /// probabilities: one a point, copied.
  TemperedSampler(std::span<const float> probabilities, int set_size, Range temperature, const Rng& rng);
  bool Next(std::span<int> set) override;

 private:
  std::vector<WeightedSampler> rungs_;
  std::size_t next_ = 0;
};

}  // namespace diffsac
