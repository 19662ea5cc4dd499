#pragma once

#include <vector>

#include "diffsac/problem/solver_space.h"

namespace diffsac {

/// Some of the points of a problem as a problem of their own: points, ratios, similarities, cameras; descriptors are
/// left out.
class PointRows {
 public:
  PointRows(const SolverSpace& whole, const std::vector<int>& rows)
      : problem_(Part(whole.problem(), rows)), space_(problem_) {}
  PointRows(const PointRows&) = delete;
  PointRows& operator=(const PointRows&) = delete;
  const SolverSpace& space() const { return space_; }

 private:
  static Problem Part(const Problem& whole, const std::vector<int>& rows) {
    Problem part;
    part.task = whole.task;
    part.inlier_threshold = whole.inlier_threshold;
    part.cameras = whole.cameras;
    part.hint1 = whole.hint1;
    part.hint2 = whole.hint2;
    part.size1 = whole.size1;
    part.size2 = whole.size2;
    part.points = whole.points(rows, Eigen::all);
    if (whole.match_ratio.size() == whole.points.rows()) part.match_ratio = whole.match_ratio(rows);
    if (whole.similarities.rows() == whole.points.rows()) part.similarities = whole.similarities(rows, Eigen::all);
    return part;
  }

  Problem problem_;
  SolverSpace space_;  ///< Borrows the problem.
};

}  // namespace diffsac
