#pragma once

#include <string>
#include <vector>

#include "diffsac/diffusion/noise_schedule.h"

namespace diffsac {

/// A place on the way from noise to data: x = α c_0 + σ ε with α² + σ² = 1.
struct TimePoint {
  /// What the network is told: the schedule's index in [0, T−1] (0 is the least noisy; may lie between two indices),
  /// or −1 for clean data, at which no network is called.
  double t = -1.0;
  double alpha = 1.0;
  double sigma = 0.0;
  /// log(α/σ) = −log of diffusers' "sigma"; +∞ for clean data, −∞ for pure noise.
  double lambda = 0.0;

  /// α and σ from λ.
  static TimePoint FromLambda(double t, double lambda);
};

/// n + 1 points with rising λ: the network is called at the first n, the last is where sampling ends.
using TimeGrid = std::vector<TimePoint>;

/// How to choose the points; see SamplerOptions.
struct TimeGridOptions {
  int steps = 10;
  std::string spacing = "linspace";
  std::string final_sigma = "zero";
  /// -1000 or less (also −∞) clips nothing.
  double lambda_min_clipped = -5.1;
};

/// Chooses `steps` points of a schedule, with the conventions of Hugging Face's diffusers for "linspace", "leading",
/// "trailing", "karras" and "lu". Indices are never repeated: where clipping leaves fewer indices than steps, all that
/// are left are used, so that a grid can be shorter than asked for (diffusers repeats them, or divides by zero).
/// Throws Error on an unknown spacing or final sigma, steps < 1 or steps > T.
TimeGrid MakeTimeGrid(const NoiseSchedule& schedule, const TimeGridOptions& options);

}  // namespace diffsac
