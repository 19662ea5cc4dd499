#pragma once

#include "diffsac/consensus/consensus_options.h"
#include "diffsac/consensus/mixture.h"
#include "diffsac/consensus/model_hooks.h"

namespace diffsac {

/// Lengths beyond these have squares that are no ordinary numbers.
constexpr double kLeastScale = 1e-150;
constexpr double kLargestScale = 1e150;

/// The lengths that scores and refits of one problem work with, linear, in the unit of its points.
struct NoiseScales {
  double threshold = 0.0;           ///< ε: what an inlier is.
  double score_threshold = 0.0;     ///< What scores and local optimisation take for it.
  double refit_threshold = 0.0;     ///< What refits take for it.
  double reweight_threshold = 0.0;  ///< What reweighted refits take for it.
  int residual_dof = 1;             ///< Degrees of freedom of a residual, for MAGSAC++.
  Mixture mixture;                  ///< Of the Gaussian-uniform score and refit.

  /// A score with these constants.
  Score MakeScore(ScoreKind kind, double inlier_prior) const {
    return Score(kind, score_threshold, mixture.sigma, mixture.Odds(inlier_prior), residual_dof);
  }

  /// Whether all are within [kLeastScale, kLargestScale].
  bool Usable() const {
    const auto usable = [](double length) { return length >= kLeastScale && length <= kLargestScale; };
    return usable(threshold) && usable(score_threshold) && usable(refit_threshold) && usable(reweight_threshold) &&
           usable(mixture.sigma);
  }
};

template <MinimalModel Model>
NoiseScales ScalesOf(const PointMatrix& points, double threshold, const ConsensusOptions& options) {
  NoiseScales scales;
  scales.threshold = threshold;
  scales.score_threshold = options.score_threshold_factor * threshold;
  scales.refit_threshold = options.refit_threshold_factor * threshold;
  scales.reweight_threshold = options.score_threshold_factor * scales.refit_threshold;
  scales.residual_dof = options.residual_dof > 0 ? options.residual_dof : ResidualDof<Model>();
  scales.mixture = MakeMixture(points, threshold, options.sigma_factor * threshold);
  return scales;
}

}  // namespace diffsac
