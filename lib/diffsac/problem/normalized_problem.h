#pragma once

#include "diffsac/problem/problem.h"

namespace diffsac {

/// Factors on the noise scales of an estimator's options (ConsensusOptions::least_scale and greatest_scale).
struct NoiseRange {
  double least = 1.0;
  double greatest = 1.0;
};

/// What an estimate computes of the data alone, once, for features, search, diagnosis and posteriors: the points in the
/// coordinates in which a model is solved (essential matrices: K⁻¹ times pixels, the threshold divided by the mean
/// focal length; others as the task's description normalises them, else the problem's own) and the matches'
/// probabilities. Borrows the problem.
class NormalizedProblem {
 public:
  explicit NormalizedProblem(const Problem& problem, const NoiseRange& noise = {});
  const Problem& problem() const { return problem_; }
  /// Whether the problem has what its task needs beside its points (HasItsNeeds). Without it nothing is normalised.
  bool is_accepted() const { return is_accepted_; }
  const PointMatrix& points() const { return is_normalized_ ? normalized_ : problem_.points; }
  double threshold() const { return problem_.inlier_threshold / unit_; }
  /// How much of the data's unit is one unit here: pixels in the mean focal length, or 1.
  double unit() const { return unit_; }
  bool is_normalized() const { return is_normalized_; }
  /// MatchPriors of the problem.
  const Eigen::VectorXd& match_probabilities() const { return match_probabilities_; }
  const NoiseRange& noise() const { return noise_; }

 private:
  const Problem& problem_;
  NoiseRange noise_;
  PointMatrix normalized_;
  Eigen::VectorXd match_probabilities_;
  double unit_ = 1.0;
  bool is_accepted_ = false;
  bool is_normalized_ = false;
};

}  // namespace diffsac
