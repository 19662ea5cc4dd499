#include "diffsac/consensus/sample_consensus.h"

namespace diffsac {

void ConsensusOptions::Bind(OptionsBinder& b) {
  b.Choice("score", score, {"inlier_count", "msac", "gaussian_uniform"});
  b.Field("score_threshold_factor", score_threshold_factor, Positive());
  b.Field("sigma_factor", sigma_factor, Positive());
  b.Field("inlier_prior", inlier_prior, Within(0.001, 0.999));
  b.Choice("local_optimization", local_optimization, {"none", "lo_ransac"});
  b.Field("local_samples", local_samples, AtLeast(0));
  b.Choice("refit", refit, {"none", "inliers", "iterated", "em"});
  b.Field("refit_rounds", refit_rounds, AtLeast(1));
  b.Field("refit_threshold_factor", refit_threshold_factor, Positive());
  b.Field("sigma_prior", sigma_prior, AtLeast(0.0));
  b.Field("refit_candidates", refit_candidates, AtLeast(1));
  b.Choice("final_score", final_score, {"inlier_count", "msac", "gaussian_uniform"});
}

}  // namespace diffsac
