#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

namespace diffsac {

/// Why the loop ended.
enum class StopReason {
  kNotRun,      ///< No draw was made: the points or the threshold were refused.
  kBudget,      ///< As many draws as were asked for.
  kConfidence,  ///< A better model is less likely than was asked for.
  kExhausted,   ///< The source had no more sets.
};

/// "not_run", "budget", "confidence" or "exhausted".
std::string_view ToString(StopReason reason);

inline constexpr std::int64_t kNeverEnough = std::numeric_limits<std::int64_t>::max();

/// The probability that a set of `set_size` points drawn without replacement holds inliers only:
/// Π (I − i)/(N − i), the hypergeometric law (not (I/N)^γ, which is too high for few points).
double AllInlierProbability(std::int64_t inliers, std::int64_t num_points, int set_size);

/// The least number of draws after which, with probability `confidence`, one at least was good:
/// ⌈multiplier · log(1 − confidence)/log(1 − p)⌉, at least 1; kNeverEnough for p = 0.
/// probability: p, of one draw being good.
std::int64_t DrawsForConfidence(double probability, double confidence, double multiplier = 1.0);

}  // namespace diffsac
