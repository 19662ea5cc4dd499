#pragma once

#include "diffsac/data/problem.h"
#include "diffsac/geometry/pose.h"

namespace diffsac {

/// The coordinates in which a model is solved and scored: the problem's own, but for the essential matrix normalised
/// ones, K⁻¹ times pixels, with the threshold divided by the mean focal length. Borrows the problem.
class SolverSpace {
 public:
  explicit SolverSpace(const Problem& problem) : problem_(problem), threshold_(problem.inlier_threshold) {
    if (problem.task != Task::kEssential || !problem.cameras || problem.points.cols() != 4) return;
    normalized_ = NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2);
    threshold_ /= problem.cameras->MeanFocal();
    is_normalized_ = true;
  }
  const PointMatrix& points() const { return is_normalized_ ? normalized_ : problem_.points; }
  double threshold() const { return threshold_; }

 private:
  const Problem& problem_;
  PointMatrix normalized_;
  double threshold_;
  bool is_normalized_ = false;
};

}  // namespace diffsac
