#include "diffsac/ransac/stopping_rule.h"

#include <algorithm>
#include <cmath>

namespace diffsac {

double AllInlierProbability(double inliers, double num_points, int set_size) {
  if (inliers < set_size || num_points < set_size) return 0.0;
  double probability = 1.0;
  for (int i = 0; i < set_size; ++i) probability *= (inliers - i) / (num_points - i);
  return std::min(probability, 1.0);
}

std::int64_t DrawsForConfidence(double probability, double confidence) {
  if (!(probability > 0.0) || confidence >= 1.0) return probability >= 1.0 ? 1 : kNeverEnough;
  if (probability >= 1.0 || !(confidence > 0.0)) return 1;
  // log1p keeps the digits of a small probability.
  const double draws = std::ceil(std::log1p(-confidence) / std::log1p(-probability));
  // 2^63 as a double; at and above it the conversion would be undefined.
  constexpr double kTooMany = 9.2233720368547758e18;
  return draws < kTooMany ? std::max<std::int64_t>(1, static_cast<std::int64_t>(draws)) : kNeverEnough;
}

void StoppingRule::Expect(double inliers) {
  probability_ = AllInlierProbability(inliers, static_cast<double>(num_points_), set_size_);
  needed_ = DrawsForConfidence(probability_, options_.confidence);
}

void StoppingRule::Update(std::int64_t inliers) {
  inliers_ = inliers;
  Expect(static_cast<double>(inliers));
}

void StoppingRule::Update(std::span<const std::uint8_t> inliers) {
  inliers_ = std::count(inliers.begin(), inliers.end(), 1);
  if (weights_.size() == 0) return Expect(static_cast<double>(inliers_));
  double weight = 0.0;
  for (std::size_t i = 0; i < inliers.size(); ++i) weight += inliers[i] ? weights_[static_cast<Eigen::Index>(i)] : 0.0;
  Expect(static_cast<double>(num_points_) * weight / weights_.sum());
}

bool StoppingRule::Finds(std::int64_t iterations) const {
  constexpr double kSure = 0.99;
  return iterations >= DrawsForConfidence(probability_, kSure);
}

StopReason StoppingRule::After(std::int64_t iterations) const {
  if (options_.stopping != Stopping::kBudget && iterations >= std::max<std::int64_t>(options_.min_iterations, needed_))
    return StopReason::kConfidence;
  return iterations >= options_.max_iterations ? StopReason::kBudget : StopReason::kNotRun;
}

}  // namespace diffsac
