#pragma once

#include <vector>

#include "diffsac/problem/deduplicated_points.h"
#include "diffsac/problem/normalized_problem.h"

namespace diffsac {

/// Some of the points of a problem as a problem of their own, with its space.
class PointRows {
 public:
  PointRows(const NormalizedProblem& whole, const std::vector<int>& rows)
      : problem_(PartOf(whole.problem(), rows)), space_(problem_) {}
  PointRows(const PointRows&) = delete;
  PointRows& operator=(const PointRows&) = delete;
  const NormalizedProblem& space() const { return space_; }

 private:
  Problem problem_;
  NormalizedProblem space_;  ///< Borrows the problem.
};

}  // namespace diffsac
