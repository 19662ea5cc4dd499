#pragma once

#include <Eigen/Core>
#include <memory>

#include "diffsac/guidance/diffusion/reverse_sampler.h"

namespace diffsac {

/// κ copies of N confidences on their way back from noise, one copy behind the other, without LibTorch.
struct ConfidenceRows {
  Eigen::ArrayXf values;  ///< κ·N

  friend ConfidenceRows operator*(double factor, const ConfidenceRows& rows) {
    return {static_cast<float>(factor) * rows.values};
  }
  friend ConfidenceRows operator/(const ConfidenceRows& rows, double divisor) {
    return {rows.values / static_cast<float>(divisor)};
  }
  friend ConfidenceRows operator+(const ConfidenceRows& a, const ConfidenceRows& b) { return {a.values + b.values}; }
  friend ConfidenceRows operator-(const ConfidenceRows& a, const ConfidenceRows& b) { return {a.values - b.values}; }
};

template <>
struct SampledValue<ConfidenceRows> {
  struct Scope {};
  static ConfidenceRows Clamp(const ConfidenceRows& rows) { return {rows.values.max(-1.0f).min(1.0f)}; }
};

extern template class ReverseSamplerOf<ConfidenceRows>;
using ConfidenceSampler = ReverseSamplerOf<ConfidenceRows>;

/// Throws Error on bad options, steps > T included.
std::unique_ptr<ConfidenceSampler> MakeConfidenceSampler(const ReverseSamplerOptions& options,
                                                         const NoiseSchedule& schedule);

}  // namespace diffsac
