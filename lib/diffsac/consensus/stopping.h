#pragma once

#include <cstdint>
#include <limits>

#include "diffsac/core/enum_names.h"

namespace diffsac {

/// Why the loop ended.
enum class StopReason {
  kNotRun,      ///< No draw was made: the points or the threshold were refused.
  kBudget,      ///< As many draws as were asked for.
  kConfidence,  ///< A better model is less likely than was asked for.
  kExhausted,   ///< The sampler had no more sets.
};

template <>
inline constexpr auto kEnumNames<StopReason> = NamesOf<StopReason>({{StopReason::kNotRun, "not_run"},
                                                                    {StopReason::kBudget, "budget"},
                                                                    {StopReason::kConfidence, "confidence"},
                                                                    {StopReason::kExhausted, "exhausted"}});

/// When a search ends.
///   kBudget      "budget": after exactly so many draws, unless the sampler runs out
///   kConfidence  "confidence": as soon as uniform draws would have found a better model
enum class Stopping { kBudget, kConfidence };
template <>
inline constexpr auto kEnumNames<Stopping> = NamesOf<Stopping>({{Stopping::kBudget, "budget"},
                                                                {Stopping::kConfidence, "confidence"}});

inline constexpr std::int64_t kNeverEnough = std::numeric_limits<std::int64_t>::max();

/// The probability that a set of `set_size` points drawn without replacement holds inliers only:
/// Π (I − i)/(N − i), the hypergeometric law (not (I/N)^γ, which is too high for few points).
double AllInlierProbability(std::int64_t inliers, std::int64_t num_points, int set_size);

/// The least number of draws after which, with probability `confidence`, one at least was good:
/// ⌈multiplier · log(1 − confidence)/log(1 − p)⌉, at least 1; kNeverEnough for p = 0.
/// probability: p, of one draw being good.
std::int64_t DrawsForConfidence(double probability, double confidence, double multiplier = 1.0);

/// Decides after each draw whether the search goes on.
class StoppingRule {
 public:
  /// γ and N of the problem; at most max_iterations draws. With kConfidence fewer, but min_iterations at
  /// least, once a set of inliers alone has been drawn with probability `confidence`.
  StoppingRule(Stopping stopping, std::int64_t max_iterations, std::int64_t min_iterations, double confidence,
               std::int64_t num_points, int set_size);
  /// The best model so far has so many inliers.
  void Update(std::int64_t inliers);
  /// kNotRun: go on.
  StopReason After(std::int64_t iterations) const;
  std::int64_t max_iterations() const { return max_iterations_; }

 private:
  Stopping stopping_;
  std::int64_t max_iterations_;
  std::int64_t min_iterations_;
  double confidence_;
  std::int64_t num_points_;
  int set_size_;
  std::int64_t needed_ = kNeverEnough;
};

}  // namespace diffsac
