#pragma once

#include <type_traits>

#include "diffsac/guidance/diffusion/sampling.h"
#include "diffsac/guidance/diffusion/time_grid.h"

namespace diffsac {

/// Lu et al., "DPM-Solver++: Fast solver for guided sampling of diffusion probabilistic models", 2022: data
/// prediction, midpoint form, multistep (2M): the slope of order 2 comes from the previous step's prediction, so that
/// each step calls the network once.
struct DpmSolverOptions {
  /// 1 or 2. Order 1 is DDIM with η = 0.
  int order = 2;
  /// The last step is of order 1 when there are fewer than 15 steps (as diffusers). A last step onto clean data
  /// always is.
  bool lower_order_final = true;
};

/// The order at which step `step` of `grid` is made: 1 or 2.
int DpmSolverOrder(const TimeGrid& grid, int step, const DpmSolverOptions& options);

/// Runs the solver along any sequence of points, continuous in λ: x stands at grid.front(), the answer at grid.back().
/// One update from s to t of order 1, given the prediction m_s at s, is
///   x_t = (σ_t/σ_s) x − α_t expm1(−h) m_s,  h = λ_t − λ_s.
/// Defined in dpm_solver_impl.h.
template <class Value>
Value RunDpmSolver(const TimeGrid& grid, const DpmSolverOptions& options,
                   const std::type_identity_t<DenoiseFunctionOf<Value>>& denoise, Value x,
                   const std::type_identity_t<StepObserverOf<Value>>& observer = {});

}  // namespace diffsac
