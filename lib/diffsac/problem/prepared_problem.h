#pragma once

#include "diffsac/problem/deduplicated_points.h"
#include "diffsac/problem/normalized_problem.h"

namespace diffsac {

/// A problem, ready to be estimated from: its finite and distinct rows, and what depends on these alone
/// (NormalizedProblem), each computed once. Borrows the problem.
class PreparedProblem {
 public:
  explicit PreparedProblem(const Problem& problem, const NoiseRange& noise = {})
      : rows_(problem), space_(rows_.problem(), noise) {}
  PreparedProblem(const PreparedProblem&) = delete;
  PreparedProblem& operator=(const PreparedProblem&) = delete;
  const DeduplicatedPoints& rows() const { return rows_; }
  const NormalizedProblem& space() const { return space_; }
  /// Of the usable rows.
  const Problem& problem() const { return rows_.problem(); }

 private:
  DeduplicatedPoints rows_;
  NormalizedProblem space_;  ///< Borrows the rows' problem.
};

}  // namespace diffsac
