#include "diffsac/consensus/structures/dgsac.h"

namespace diffsac {

void DgsacOptions::Bind(OptionsBinder& b) {
  b.Field("max_iterations", max_iterations, Within(1, 1e6))
      .Help("minimal sets: at most, or exactly so many with stopping: budget");
  b.Field("stopping", stopping).Help("explained, the paper's: once another round explains fewer than γ points better");
  b.Field("guided", guided).Help("false: uniform sets, for comparison");
  b.Field("choose", choose).Help("the one model of data with several structures");
  b.Field("refit", refit).Help("of each structure, on the inliers that its density tells");
  b.Field("refit_rounds", refit_rounds, AtLeast(1))
      .OnlyIf(refit == DgsacRefit::kDensity, "refit: density")
      .Help("at most");
}

}  // namespace diffsac
