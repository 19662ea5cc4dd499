#include "lab/train/learning_rate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace diffsac {

double LearningRate(std::int64_t step, std::int64_t warmup, std::int64_t total, double peak) {
  if (step < warmup) return peak * static_cast<double>(step + 1) / static_cast<double>(warmup);
  const double span = static_cast<double>(std::max<std::int64_t>(1, total - warmup));
  const double done = std::min(1.0, static_cast<double>(step - warmup) / span);
  return peak * 0.5 * (1.0 + std::cos(std::numbers::pi * done));
}

}  // namespace diffsac
