#include "diffsac/guidance/diffusion/dpm_solver.h"

#include <cmath>

namespace diffsac {
namespace {

/// Below this many steps the last one is of order 1, as in diffusers.
constexpr int kFewSteps = 15;

}  // namespace

int DpmSolverOrder(const TimeGrid& grid, int step, const DpmSolverOptions& options) {
  const int steps = static_cast<int>(grid.size()) - 1;
  const bool last = step == steps - 1;
  if (options.order == 1 || std::isinf(grid[step + 1].lambda)) return 1;
  if (step == 0 || (last && options.lower_order_final && steps < kFewSteps)) return 1;
  return 2;
}

}  // namespace diffsac
