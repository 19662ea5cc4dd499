#pragma once

#include <torch/types.h>

#include "diffsac/guidance/diffusion/noise_schedule.h"

namespace diffsac {

/// The input of diffusers' scheduler tests: 0/768 … 767/768 (their permutation of axes changes no mean).
inline torch::Tensor DummySample() { return torch::arange(768, torch::kFloat64) / 768.0; }
/// The noise of those tests: the same numbers backwards.
inline torch::Tensor DummyNoise() { return DummySample().flip(0); }
/// The network of those tests.
inline torch::Tensor DummyModel(const torch::Tensor& x, double t) { return x * (t / (t + 1.0)); }

inline double MeanAbs(const torch::Tensor& x) { return x.abs().mean().item<double>(); }

/// A schedule without changing any other option.
inline NoiseSchedule MakeSchedule(const char* kind, int steps = 100, bool zero_terminal_snr = false) {
  NoiseScheduleOptions options;
  options.kind = FromString<NoiseScheduleKind>(kind);
  options.steps = steps;
  options.zero_terminal_snr = zero_terminal_snr;
  return NoiseSchedule(options);
}

}  // namespace diffsac
