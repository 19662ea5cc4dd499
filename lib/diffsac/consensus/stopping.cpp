#include "diffsac/consensus/stopping.h"

#include <algorithm>
#include <cmath>

namespace diffsac {

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

StoppingRule::StoppingRule(Stopping stopping, std::int64_t max_iterations, std::int64_t min_iterations,
                           double confidence, std::int64_t num_points, int set_size)
    : stopping_(stopping),
      max_iterations_(max_iterations),
      min_iterations_(min_iterations),
      confidence_(confidence),
      num_points_(num_points),
      set_size_(set_size) {}

void StoppingRule::Update(std::int64_t inliers) {
  needed_ = DrawsForConfidence(AllInlierProbability(inliers, num_points_, set_size_), confidence_);
}

StopReason StoppingRule::After(std::int64_t iterations) const {
  if (stopping_ != Stopping::kBudget && iterations >= std::max(min_iterations_, needed_))
    return StopReason::kConfidence;
  return iterations >= max_iterations_ ? StopReason::kBudget : StopReason::kNotRun;
}

}  // namespace diffsac
