#include "diffsac/network/dpm_solver.h"

#include <cmath>

namespace diffsac {
namespace {

/// Below this many steps the last one of 2M is of order 1, as in diffusers.
constexpr int kFewSteps = 15;

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

}  // namespace diffsac
