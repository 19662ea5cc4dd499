#include "diffsac/diffusion/dpm_solver.h"

#include <torch/torch.h>

#include <cmath>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

/// Below this many steps the last one of 2M is of order 1, as in diffusers.
constexpr int kFewSteps = 15;
/// Where 2S evaluates inside its step, as a fraction of h.
constexpr double kMiddle = 0.5;

/// Exponential integrator shared by all updates: x_t from x_s and the predictions' average D over the step.
torch::Tensor Advance(const torch::Tensor& x, const torch::Tensor& direction, const TimePoint& s, const TimePoint& t) {
  const double h = t.lambda - s.lambda;
  return (t.sigma / s.sigma) * x - (t.alpha * std::expm1(-h)) * direction;
}

/// The same for the reverse SDE: x shrinks by another e^(−h), which fresh noise makes up for.
torch::Tensor AdvanceSde(const torch::Tensor& x, const torch::Tensor& m_s, const torch::Tensor& slope,
                         const TimePoint& s, const TimePoint& t, const NoiseFunction& noise, int step) {
  const double h = t.lambda - s.lambda;
  const double gain = -t.alpha * std::expm1(-2.0 * h);
  auto next = (t.sigma / s.sigma * std::exp(-h)) * x + gain * m_s;
  if (slope.defined()) next = next + (0.5 * gain) * slope;
  const double noise_scale = t.sigma * std::sqrt(-std::expm1(-2.0 * h));
  return noise_scale > 0.0 ? next + noise_scale * noise(step) : next;
}

}  // namespace

int DpmSolverOrder(const TimeGrid& grid, int step, const DpmSolverOptions& options) {
  const int steps = static_cast<int>(grid.size()) - 1;
  const bool last = step == steps - 1;
  if (options.order == 1 || std::isinf(grid[step + 1].lambda)) return 1;
  // A step from no signal at all has no middle, and its prediction no influence on the slope.
  if (!options.multistep) return std::isinf(grid[step].lambda) ? 1 : 2;
  if (step == 0 || (last && options.lower_order_final && steps < kFewSteps)) return 1;
  // A step of no length, or after one of no length ("karras" and "lu" end on index 0), has no slope.
  const bool moves = grid[step + 1].lambda > grid[step].lambda && grid[step].lambda > grid[step - 1].lambda;
  return moves ? 2 : 1;
}

torch::Tensor DpmSolverFirstOrder(const torch::Tensor& x, const torch::Tensor& m_s, const TimePoint& s,
                                  const TimePoint& t) {
  return Advance(x, m_s, s, t);
}

torch::Tensor RunDpmSolver(const TimeGrid& grid, const DpmSolverOptions& options, const DenoiseFunction& denoise,
                           torch::Tensor x, const NoiseFunction& noise, const StepObserver& observer,
                           const std::function<TimePoint(double lambda)>& lambda_to_point) {
  if (grid.size() < 2) throw Error("DPM-Solver++: needs at least two points in time");
  torch::Tensor previous;
  for (int step = 0; step + 1 < static_cast<int>(grid.size()); ++step) {
    const TimePoint& s = grid[step];
    const TimePoint& t = grid[step + 1];
    const double h = t.lambda - s.lambda;
    const auto m = denoise(x, s.t);
    if (observer) observer(step, s.t, x, m);

    torch::Tensor slope;  // D1: the prediction's change over the step, by extrapolation or from the middle
    if (DpmSolverOrder(grid, step, options) == 2 && options.multistep) {
      const double ratio = (s.lambda - grid[step - 1].lambda) / h;
      slope = (m - previous) / ratio;
    } else if (DpmSolverOrder(grid, step, options) == 2) {
      const TimePoint middle = lambda_to_point(s.lambda + kMiddle * h);
      slope = (denoise(Advance(x, m, s, middle), middle.t) - m) / kMiddle;
    }
    if (options.sde) {
      x = AdvanceSde(x, m, slope, s, t, noise, step);
    } else {
      x = Advance(x, slope.defined() ? m + 0.5 * slope : m, s, t);
    }
    previous = m;
  }
  return x;
}

}  // namespace diffsac
