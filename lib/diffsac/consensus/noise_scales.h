#pragma once

#include "diffsac/consensus/consensus_options.h"
#include "diffsac/consensus/mixture.h"
#include "diffsac/consensus/model_hooks.h"

namespace diffsac {

/// The lengths that scores and refits of one problem work with, linear, in the unit of its points.
struct NoiseScales {
  double threshold = 0.0;        ///< ε: what an inlier is.
  double score_threshold = 0.0;  ///< What scores and local optimisation take for it.
  double refit_threshold = 0.0;  ///< What refits take for it.
  int residual_dof = 1;          ///< Degrees of freedom of a residual, for MAGSAC++.
  Mixture mixture;               ///< Of the Gaussian-uniform score and refit.

  /// A score with these constants.
  Score MakeScore(ScoreKind kind, double inlier_prior) const {
    return Score(kind, score_threshold, mixture.sigma, mixture.Odds(inlier_prior), residual_dof);
  }
};

template <MinimalModel Model>
NoiseScales ScalesOf(const PointMatrix& points, double threshold, const ConsensusOptions& options) {
  NoiseScales scales;
  scales.threshold = threshold;
  scales.score_threshold = options.score_threshold_factor * threshold;
  scales.refit_threshold = options.refit_threshold_factor * threshold;
  scales.residual_dof = options.residual_dof > 0 ? options.residual_dof : ResidualDof<Model>();
  scales.mixture = MakeMixture(points, threshold, options.sigma_factor * threshold);
  return scales;
}

}  // namespace diffsac
