#pragma once

// The solver behind dpm_solver.h, for the files that instantiate it for a kind of value.

#include <cmath>
#include <optional>

#include "diffsac/core/status.h"
#include "diffsac/guidance/diffusion/dpm_solver.h"

namespace diffsac {

/// Exponential integrator: x_t from x_s and the predictions' average D over the step.
template <class Value>
Value DpmSolverAdvance(const Value& x, const Value& direction, const TimePoint& s, const TimePoint& t) {
  const double h = t.lambda - s.lambda;
  return (t.sigma / s.sigma) * x - (t.alpha * std::expm1(-h)) * direction;
}

template <class Value>
Value RunDpmSolver(const TimeGrid& grid, const DpmSolverOptions& options,
                   const std::type_identity_t<DenoiseFunctionOf<Value>>& denoise, Value x,
                   const std::type_identity_t<StepObserverOf<Value>>& observer) {
  if (grid.size() < 2) throw Error("DPM-Solver++: needs at least two points in time");
  std::optional<Value> previous;
  for (int step = 0; step + 1 < static_cast<int>(grid.size()); ++step) {
    const TimePoint& s = grid[step];
    const TimePoint& t = grid[step + 1];
    const double h = t.lambda - s.lambda;
    const Value m = denoise(x, s.t);
    if (observer) observer(step, s.t, x, m);

    std::optional<Value> slope;  // D1: the prediction's change over the step, extrapolated
    if (DpmSolverOrder(grid, step, options) == 2) {
      const double ratio = (s.lambda - grid[step - 1].lambda) / h;
      slope = (m - *previous) / ratio;
    }
    x = DpmSolverAdvance<Value>(x, slope ? m + 0.5 * *slope : m, s, t);
    previous = m;
  }
  return x;
}

}  // namespace diffsac
