#pragma once

// The solver behind dpm_solver.h, for the files that instantiate it for a kind of value.

#include <cmath>
#include <optional>

#include "diffsac/core/status.h"
#include "diffsac/network/dpm_solver.h"

namespace diffsac {

/// Where 2S evaluates inside its step, as a fraction of h.
inline constexpr double kDpmSolverMiddle = 0.5;

/// Exponential integrator shared by all updates: x_t from x_s and the predictions' average D over the step.
template <class Value>
Value DpmSolverAdvance(const Value& x, const Value& direction, const TimePoint& s, const TimePoint& t) {
  const double h = t.lambda - s.lambda;
  return (t.sigma / s.sigma) * x - (t.alpha * std::expm1(-h)) * direction;
}

/// The same for the reverse SDE: x shrinks by another e^(−h), which fresh noise makes up for.
template <class Value>
Value DpmSolverAdvanceSde(const Value& x, const Value& m_s, const std::optional<Value>& slope, const TimePoint& s,
                          const TimePoint& t, const NoiseFunctionOf<Value>& noise, int step) {
  const double h = t.lambda - s.lambda;
  const double gain = -t.alpha * std::expm1(-2.0 * h);
  Value next = (t.sigma / s.sigma * std::exp(-h)) * x + gain * m_s;
  if (slope) next = next + (0.5 * gain) * *slope;
  const double noise_scale = t.sigma * std::sqrt(-std::expm1(-2.0 * h));
  return noise_scale > 0.0 ? next + noise_scale * noise(step) : next;
}

template <class Value>
Value RunDpmSolver(const TimeGrid& grid, const DpmSolverOptions& options,
                   const std::type_identity_t<DenoiseFunctionOf<Value>>& denoise, Value x,
                   const std::type_identity_t<NoiseFunctionOf<Value>>& noise,
                   const std::type_identity_t<StepObserverOf<Value>>& observer,
                   const std::function<TimePoint(double lambda)>& lambda_to_point) {
  if (grid.size() < 2) throw Error("DPM-Solver++: needs at least two points in time");
  std::optional<Value> previous;
  for (int step = 0; step + 1 < static_cast<int>(grid.size()); ++step) {
    const TimePoint& s = grid[step];
    const TimePoint& t = grid[step + 1];
    const double h = t.lambda - s.lambda;
    const Value m = denoise(x, s.t);
    if (observer) observer(step, s.t, x, m);

    std::optional<Value> slope;  // D1: the prediction's change over the step, by extrapolation or from the middle
    if (DpmSolverOrder(grid, step, options) == 2 && options.multistep) {
      const double ratio = (s.lambda - grid[step - 1].lambda) / h;
      slope = (m - *previous) / ratio;
    } else if (DpmSolverOrder(grid, step, options) == 2) {
      const TimePoint middle = lambda_to_point(s.lambda + kDpmSolverMiddle * h);
      slope = (denoise(DpmSolverAdvance(x, m, s, middle), middle.t) - m) / kDpmSolverMiddle;
    }
    if (options.sde) {
      x = DpmSolverAdvanceSde(x, m, slope, s, t, noise, step);
    } else {
      x = DpmSolverAdvance<Value>(x, slope ? m + 0.5 * *slope : m, s, t);
    }
    previous = m;
  }
  return x;
}

}  // namespace diffsac
