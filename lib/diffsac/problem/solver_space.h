#pragma once

#include "diffsac/problem/problem.h"

namespace diffsac {

/// The coordinates in which a model is solved and scored, made once for an estimate, checked once (CheckSpace in
/// problem/tasks.h) and handed to features and consensus: the problem's own, unless the task's description normalises
/// them (the essential matrix: K⁻¹ times pixels, the threshold divided by the mean focal length). Borrows the problem.
class SolverSpace {
 public:
  explicit SolverSpace(const Problem& problem);
  const Problem& problem() const { return problem_; }
  /// Whether the problem has what its task needs beside its points (HasItsNeeds). Without it nothing is normalised.
  bool is_accepted() const { return is_accepted_; }
  const PointMatrix& points() const { return is_normalized_ ? normalized_ : problem_.points; }
  double threshold() const { return problem_.inlier_threshold / unit_; }
  /// How much of the data's unit is one unit here: pixels in the mean focal length, or 1.
  double unit() const { return unit_; }
  bool is_normalized() const { return is_normalized_; }

 private:
  const Problem& problem_;
  PointMatrix normalized_;
  double unit_ = 1.0;
  bool is_accepted_ = false;
  bool is_normalized_ = false;
};

}  // namespace diffsac
