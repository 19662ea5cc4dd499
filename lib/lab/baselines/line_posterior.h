#pragma once

#include "diffsac/core/options.h"
#include "diffsac/estimators/robust_estimator.h"

namespace diffsac {

/// What the posterior is told about the generator, beyond the points: see docs/generators.md.
struct LinePosteriorOptions {
  double side = 10.0;               ///< The picture is [0, side]².
  double min_extent = 5.0;          ///< Shortest chord.
  double sigma_factor = 1.0 / 3.0;  ///< σ as a multiple of the problem's ε.
  double tolerance_deg = 0.5;       ///< Of the accuracy that is maximised, as the metric's.
  int max_iterations = 5000;  ///< Pairs that the search for modes starts from; all of them when there are no more.
  int candidates = 30;        ///< Hypotheses, best first by MSAC, that are refined to modes.
  void Bind(OptionsBinder& b);
};

/// The Bayes estimate of a line under the generator itself (`synthetic_line`, `through_point`, Gaussian noise, uniform
/// outliers): what an estimator that knows everything but the line, the inliers and their share can reach. A reference
/// for tables, as the oracle is, and useless on other data: no learned or exhaustive search can be expected to beat it.
///
/// Likelihood of a line: Π [w/L · N(r; σ) + (1 − w)/side²], with L its chord and the share of inliers w integrated out
/// over (0, 1); prior: L for chords of at least min_extent (a line through a uniform point). The modes are refined by
/// expectation maximisation and each is integrated on a grid of 41 × 17 over ±6 standard deviations of the angle and ±4
/// of the offset at the centroid. The answer is the line that maximises the expected accuracy, 1 − error/tolerance_deg
/// where positive, under the posterior; the score is that expectation times N.
class LinePosteriorEstimator : public RobustEstimator {
 public:
  explicit LinePosteriorEstimator(const LinePosteriorOptions& options) : options_(options) { CheckOptions(options); }
  Estimate DoRun(const Problem& problem, std::uint64_t seed) const override;

 private:
  LinePosteriorOptions options_;
};

}  // namespace diffsac
