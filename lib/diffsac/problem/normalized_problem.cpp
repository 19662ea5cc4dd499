#include "diffsac/problem/normalized_problem.h"

#include "diffsac/problem/match_probabilities.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {

NormalizedProblem::NormalizedProblem(const Problem& problem, const NoiseRange& noise)
    : problem_(problem), noise_(noise), match_probabilities_(MatchPriors(problem)) {
  DispatchDescription(problem.task, [&]<class Description>() {
    is_accepted_ = Description::Accepts(problem);
    if constexpr (requires { Description::Normalize(problem, &unit_); }) {
      if (!is_accepted_ || problem.points.cols() != Description::Model::kDimension) return;
      normalized_ = Description::Normalize(problem, &unit_);
      is_normalized_ = true;
    }
  });
}

}  // namespace diffsac
