#pragma once

#include "diffsac/problem/solver_space.h"
#include "diffsac/problem/usable_rows.h"

namespace diffsac {

/// A problem, ready to be estimated from: its finite and distinct rows, and what depends on these alone (SolverSpace),
/// each computed once. Borrows the problem.
class PreparedProblem {
 public:
  explicit PreparedProblem(const Problem& problem, const NoiseRange& noise = {})
      : rows_(problem), space_(rows_.problem(), noise) {}
  PreparedProblem(const PreparedProblem&) = delete;
  PreparedProblem& operator=(const PreparedProblem&) = delete;
  const UsableRows& rows() const { return rows_; }
  const SolverSpace& space() const { return space_; }
  /// Of the usable rows.
  const Problem& problem() const { return rows_.problem(); }

 private:
  UsableRows rows_;
  SolverSpace space_;  ///< Borrows the rows' problem.
};

}  // namespace diffsac
