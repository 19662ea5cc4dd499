#include "diffsac/ransac/sample_consensus.h"

#include <algorithm>
#include <cmath>

#include "diffsac/ransac/sample_consensus_impl.h"

namespace diffsac {

ScorePrior ScorePriorOf(const EstimationPriors& priors, const ConsensusOptions& options, Eigen::Index num_points) {
  ScorePrior prior{{}, priors.cameras, priors.turns, options.keypoint_orientation_weight};
  if (options.inlier_prior_power > 0.0 && priors.inlier_priors.size() == num_points) {
    const Eigen::ArrayXd probabilities = priors.inlier_priors.unaryExpr(
        [](double value) { return std::isnan(value) ? 0.0 : std::clamp(value, 0.0, 1.0); });
    prior.weights = probabilities.pow(options.inlier_prior_power);
  }
  return prior;
}

}  // namespace diffsac
