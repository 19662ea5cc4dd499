#include "diffsac/guidance/diffusion/time_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

// Far below any λ of a schedule but that of no signal at all, −∞, which must pass as well.
constexpr double kNoClipping = -1000.0;

TimePoint AtIndex(const NoiseSchedule& schedule, int t) {
  return {static_cast<double>(t), schedule.alpha(t), schedule.sigma(t), schedule.lambda(t)};
}

TimePoint CleanData() { return {-1.0, 1.0, 0.0, std::numeric_limits<double>::infinity()}; }

/// How many indices have λ ≥ `minimum`: those are 0…count−1.
int UsableIndices(const NoiseSchedule& schedule, double minimum) {
  int count = schedule.steps();
  if (minimum <= kNoClipping) return count;
  while (count > 1 && schedule.lambda(count - 1) < minimum) --count;
  return count;
}

// std::nearbyint rounds halves to even, as NumPy does: 499.5 becomes 500, 498.5 becomes 498.

std::vector<int> LinspaceIndices(int usable, int steps) {
  std::vector<int> indices;
  const double stride = static_cast<double>(usable - 1) / steps;
  for (int k = steps; k >= 1; --k) {
    const double exact = k == steps ? usable - 1 : k * stride;
    indices.push_back(static_cast<int>(std::nearbyint(exact)));
  }
  return indices;
}

std::vector<int> LeadingIndices(int usable, int steps) {
  std::vector<int> indices;
  const int stride = usable / (steps + 1);
  for (int k = steps; k >= 1; --k) indices.push_back(k * stride);
  return indices;
}

std::vector<int> TrailingIndices(int usable, int total, int steps) {
  std::vector<int> indices;
  const double stride = static_cast<double>(total) / steps;
  for (int k = 0; k < steps; ++k) {
    const int index = static_cast<int>(std::nearbyint(usable - k * stride)) - 1;
    if (index < 0) break;
    indices.push_back(index);
  }
  return indices;
}

std::vector<int> AllIndices(int usable) {
  std::vector<int> indices;
  for (int t = usable - 1; t >= 0; --t) indices.push_back(t);
  return indices;
}

std::vector<int> SpacedIndices(const NoiseSchedule& schedule, const TimeGridOptions& options, int usable) {
  if (options.spacing == TimestepSpacing::kTrailing) return TrailingIndices(usable, schedule.steps(), options.steps);
  // As many steps as indices: rounding would repeat some.
  if (options.steps >= usable) return AllIndices(usable);
  if (options.spacing == TimestepSpacing::kLeading) return LeadingIndices(usable, options.steps);
  return LinspaceIndices(usable, options.steps);
}

void CheckSteps(const NoiseSchedule& schedule, const TimeGridOptions& options) {
  if (options.steps < 1) throw Error("sampler: steps must be at least 1");
  if (options.steps > schedule.steps()) {
    throw Error("sampler: " + std::to_string(options.steps) + " steps are more than the noise schedule's " +
                std::to_string(schedule.steps()));
  }
  if (std::isnan(options.lambda_min_clipped)) throw Error("sampler: lambda_min_clipped is not a number");
}

}  // namespace

TimeGrid MakeTimeGrid(const NoiseSchedule& schedule, const TimeGridOptions& options) {
  CheckSteps(schedule, options);
  const int usable = UsableIndices(schedule, options.lambda_min_clipped);
  TimeGrid grid;
  for (const int t : SpacedIndices(schedule, options, usable)) grid.push_back(AtIndex(schedule, t));
  grid.push_back(options.final_sigma == FinalSigma::kZero ? CleanData() : AtIndex(schedule, 0));
  return grid;
}

}  // namespace diffsac
