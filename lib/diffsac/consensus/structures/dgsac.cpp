#include "diffsac/consensus/structures/dgsac.h"

namespace diffsac {

void DgsacOptions::Bind(OptionsBinder& b) {
  b.Field("max_iterations", max_iterations, Within(1, 1e6))
      .Help("minimal sets: at most, or exactly so many with stopping: budget");
  b.Field("stopping", stopping).Help("explained, the paper's: once another round explains fewer than γ points better");
  b.Field("explained_change", explained_change, AtLeast(0.0))
      .Help("a point is explained once a round raises its explanation by no more than this share");
  b.Field("guided", guided).Help("false: uniform sets, for comparison");
  b.Field("preferred", preferred, Within(1, 1e6)).Help("T, hypotheses that a point prefers");
  b.Field("round_size", round_size, AtLeast(0))
      .Help("sets drawn between two looks at the densities, at most; 0: a quarter of hypotheses");
  b.Field("min_contrast", min_contrast, AtLeast(0.0)).Help("least contrast of a hypothesis; less is a flat density");
  b.Field("same_structure", same_structure, Within(0.0, 1.0))
      .Help("correlation from which two hypotheses stand for one structure");
  b.Field("choose", choose).Help("the one model of data with several structures");
  b.Field("refit", refit).Help("of each structure, on the inliers that its density tells");
  b.Field("refit_rounds", refit_rounds, AtLeast(1))
      .OnlyIf(refit == DgsacRefit::kDensity, "refit: density")
      .Help("at most");
}

}  // namespace diffsac
