#pragma once

#include <vector>

#include "diffsac/guidance/diffusion/noise_schedule.h"

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
};

/// n + 1 points with rising λ: the network is called at the first n, the last is where sampling ends.
using TimeGrid = std::vector<TimePoint>;

/// Where the network is called: at equal steps of the index, as diffusers.
enum class TimestepSpacing { kLinspace, kLeading, kTrailing };
template <>
inline constexpr auto kEnumNames<TimestepSpacing> = NamesOf<TimestepSpacing>({{TimestepSpacing::kLinspace, "linspace"},
                                                                              {TimestepSpacing::kLeading, "leading"},
                                                                              {TimestepSpacing::kTrailing,
                                                                               "trailing"}});

/// Where the last step ends: on clean data (the answer is the last ĉ_0), or at index 0.
enum class FinalSigma { kZero, kSigmaMin };
template <>
inline constexpr auto kEnumNames<FinalSigma> = NamesOf<FinalSigma>({{FinalSigma::kZero, "zero"},
                                                                    {FinalSigma::kSigmaMin, "sigma_min"}});

/// How to choose the points; see ReverseSamplerOptions.
struct TimeGridOptions {
  int steps = 10;
  TimestepSpacing spacing = TimestepSpacing::kLinspace;
  FinalSigma final_sigma = FinalSigma::kZero;
  /// -1000 or less (also −∞) clips nothing.
  double lambda_min_clipped = -5.1;
};

/// Chooses `steps` points of a schedule, with the conventions of Hugging Face's diffusers. Indices are never repeated:
/// where clipping leaves fewer indices than steps, all that are left are used, so that a grid can be shorter than asked
/// for (diffusers repeats them, or divides by zero). Throws Error on steps < 1 or steps > T.
TimeGrid MakeTimeGrid(const NoiseSchedule& schedule, const TimeGridOptions& options);

}  // namespace diffsac
