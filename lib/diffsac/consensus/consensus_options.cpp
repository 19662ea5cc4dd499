#include "diffsac/consensus/consensus_kinds.h"
#include "diffsac/consensus/sample_consensus.h"

namespace diffsac {

void ConsensusOptions::Bind(OptionsBinder& b) {
  b.Choice("score", score, {"inlier_count", "msac", "gaussian_uniform", "magsac_pp"});
  b.Field("score_threshold_factor", score_threshold_factor, Positive());
  b.Field("residual_dof", residual_dof, Within(0, 6));
  b.Field("sigma_factor", sigma_factor, Positive());
  b.Field("inlier_prior", inlier_prior, Within(0.001, 0.999));
  b.Choice("local_optimization", local_optimization, {"none", "lo_ransac", "irls", "gc_ransac", "lm"});
  b.Field("local_samples", local_samples, AtLeast(0));
  b.Field("irls_rounds", irls_rounds, AtLeast(1));
  b.Field("graph_neighbors", graph_neighbors, AtLeast(1));
  b.Field("spatial_weight", spatial_weight, Within(0.0, 1e3));
  b.Field("sprt", sprt);
  b.Choice("stopping", stopping, {"budget", "confidence"});
  b.Field("max_iterations", max_iterations, AtLeast(1));
  b.Field("min_iterations", min_iterations, AtLeast(0));
  b.Field("confidence", confidence, Within(0.0, 1.0 - 1e-9));
  b.Choice("refit", refit, {"none", "inliers", "iterated", "em", "irls"});
  b.Field("refit_rounds", refit_rounds, AtLeast(1));
  b.Field("refit_threshold_factor", refit_threshold_factor, Positive());
  b.Field("sigma_prior", sigma_prior, AtLeast(0.0));
  b.Field("refit_candidates", refit_candidates, AtLeast(1));
  b.Choice("final_refinement", final_refinement, {"none", "lm"});
  b.Choice("final_score", final_score, {"inlier_count", "msac", "gaussian_uniform", "magsac_pp"});
  b.Field("block_size", block_size, AtLeast(0));
}

LocalOptimization LocalOptimizationFromString(const std::string& name) {
  if (name == "none") return LocalOptimization::kNone;
  if (name == "lo_ransac") return LocalOptimization::kInnerSamples;
  if (name == "irls") return LocalOptimization::kReweighted;
  if (name == "gc_ransac") return LocalOptimization::kGraphCut;
  if (name == "lm") return LocalOptimization::kRefine;
  throw Error("unknown local_optimization '" + name + "': expected none, lo_ransac, irls, gc_ransac or lm");
}

Refit RefitFromString(const std::string& name) {
  if (name == "none") return Refit::kNone;
  if (name == "inliers") return Refit::kInliers;
  if (name == "iterated") return Refit::kIterated;
  if (name == "em") return Refit::kMixture;
  if (name == "irls") return Refit::kReweighted;
  throw Error("unknown refit '" + name + "': expected none, inliers, iterated, em or irls");
}

bool FinalRefinementFromString(const std::string& name) {
  if (name == "none" || name == "lm") return name == "lm";
  throw Error("unknown final_refinement '" + name + "': expected none or lm");
}

bool StopsByConfidence(const std::string& name) {
  if (name == "budget" || name == "confidence") return name == "confidence";
  throw Error("unknown stopping '" + name + "': expected budget or confidence");
}

}  // namespace diffsac
