#pragma once

#include <vector>

#include "diffsac/problem/solver_space.h"
#include "diffsac/problem/usable_rows.h"

namespace diffsac {

/// Some of the points of a problem as a problem of their own, with its space.
class PointRows {
 public:
  PointRows(const SolverSpace& whole, const std::vector<int>& rows)
      : problem_(PartOf(whole.problem(), rows)), space_(problem_) {}
  PointRows(const PointRows&) = delete;
  PointRows& operator=(const PointRows&) = delete;
  const SolverSpace& space() const { return space_; }

 private:
  Problem problem_;
  SolverSpace space_;  ///< Borrows the problem.
};

}  // namespace diffsac
