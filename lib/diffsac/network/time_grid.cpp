#include "diffsac/network/time_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr double kKarrasRho = 7.0;
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

double Interpolate(double from, double to, int k, int last) { return last == 0 ? from : from + (to - from) * k / last; }

/// λ of step k of `steps`, from `first` (noisy) towards `last` (index 0). "karras" and "lu" reach `last`, as in
/// diffusers; "uniform_lambda" keeps it for the end of the last step.
double SpacedLambda(TimestepSpacing spacing, double first, double last, int k, int steps) {
  if (spacing == TimestepSpacing::kUniformLambda) return Interpolate(first, last, k, steps);
  if (spacing == TimestepSpacing::kLu) return Interpolate(first, last, k, steps - 1);
  const double root = Interpolate(std::exp(-first / kKarrasRho), std::exp(-last / kKarrasRho), k, steps - 1);
  return -kKarrasRho * std::log(root);
}

TimeGrid GridByLambda(const NoiseSchedule& schedule, const TimeGridOptions& options, int usable) {
  const double last = schedule.lambda(0);
  double first = schedule.lambda(schedule.steps() - 1);
  // Clipping is exact where points need not stand on an index.
  if (usable < schedule.steps()) first = std::min(options.lambda_min_clipped, last);
  if (std::isinf(first)) {
    throw Error("sampler: timestep_spacing " + ToString(options.spacing) +
                " needs a finite lambda_min_clipped with a zero-terminal-SNR schedule");
  }
  TimeGrid grid;
  for (int k = 0; k < options.steps; ++k) {
    const double lambda = SpacedLambda(options.spacing, first, last, k, options.steps);
    const double t = schedule.TimestepOfLambda(lambda);
    grid.push_back(
        TimePoint::FromLambda(options.spacing == TimestepSpacing::kUniformLambda ? t : std::nearbyint(t), lambda));
  }
  return grid;
}

bool IsByLambda(TimestepSpacing spacing) {
  return spacing == TimestepSpacing::kUniformLambda || spacing == TimestepSpacing::kKarras ||
         spacing == TimestepSpacing::kLu;
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

TimePoint TimePoint::FromLambda(double t, double lambda) {
  return {t, 1.0 / std::sqrt(1.0 + std::exp(-2.0 * lambda)), 1.0 / std::sqrt(1.0 + std::exp(2.0 * lambda)), lambda};
}

TimeGrid MakeTimeGrid(const NoiseSchedule& schedule, const TimeGridOptions& options) {
  CheckSteps(schedule, options);
  const int usable = UsableIndices(schedule, options.lambda_min_clipped);
  TimeGrid grid;
  if (IsByLambda(options.spacing)) {
    grid = GridByLambda(schedule, options, usable);
  } else {
    for (const int t : SpacedIndices(schedule, options, usable)) grid.push_back(AtIndex(schedule, t));
  }
  grid.push_back(options.final_sigma == FinalSigma::kZero ? CleanData() : AtIndex(schedule, 0));
  return grid;
}

}  // namespace diffsac
