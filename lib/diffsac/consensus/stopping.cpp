#include "diffsac/consensus/stopping.h"

#include <algorithm>
#include <cmath>

namespace diffsac {

std::string_view ToString(StopReason reason) {
  switch (reason) {
    case StopReason::kNotRun:
      return "not_run";
    case StopReason::kBudget:
      return "budget";
    case StopReason::kConfidence:
      return "confidence";
    case StopReason::kExhausted:
      break;
  }
  return "exhausted";
}

double AllInlierProbability(std::int64_t inliers, std::int64_t num_points, int set_size) {
  if (inliers < set_size || num_points < set_size) return 0.0;
  double probability = 1.0;
  for (int i = 0; i < set_size; ++i)
    probability *= static_cast<double>(inliers - i) / static_cast<double>(num_points - i);
  return std::min(probability, 1.0);
}

std::int64_t DrawsForConfidence(double probability, double confidence, double multiplier) {
  if (!(probability > 0.0) || confidence >= 1.0) return probability >= 1.0 ? 1 : kNeverEnough;
  if (probability >= 1.0 || !(confidence > 0.0)) return 1;
  // log1p keeps the digits of a small probability.
  const double draws = std::ceil(multiplier * std::log1p(-confidence) / std::log1p(-probability));
  // 2^63 as a double; at and above it the conversion would be undefined.
  constexpr double kTooMany = 9.2233720368547758e18;
  return draws < kTooMany ? std::max<std::int64_t>(1, static_cast<std::int64_t>(draws)) : kNeverEnough;
}

}  // namespace diffsac
