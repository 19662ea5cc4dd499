#include "diffsac/data/solver_space.h"

#include "diffsac/data/tasks.h"

namespace diffsac {

SolverSpace::SolverSpace(const Problem& problem) : problem_(problem) {
  DispatchDescription(problem.task, [&]<class Description>() {
    if constexpr (requires { Description::Normalize(problem, &unit_); }) {
      if (!Description::Accepts(problem) || problem.points.cols() != Description::Model::kDimension) return;
      normalized_ = Description::Normalize(problem, &unit_);
      is_normalized_ = true;
    }
  });
}

}  // namespace diffsac
