#include "diffsac/consensus/consensus_options.h"

#include "diffsac/consensus/option_names.h"
#include "diffsac/core/options.h"

namespace diffsac {
namespace {

void BindStopping(ConsensusOptions& o, OptionsBinder& b) {
  b.Field("stopping", o.stopping)
      .Help("budget: exactly so many draws; confidence: until uniform draws would be confident");
  b.Field("max_iterations", o.max_iterations, Within(1, 1e7)).Help("minimal sets drawn, at most");
  const bool by_confidence = o.stopping != Stopping::kBudget;
  b.Field("min_iterations", o.min_iterations, Within(0, 1e7))
      .OnlyIf(by_confidence, "stopping: confidence")
      .Help("minimal sets drawn, at least");
  b.Field("confidence", o.confidence, Within(0.0, 1.0 - 1e-9))
      .OnlyIf(by_confidence, "stopping: confidence")
      .Help("probability that a set of the best model's inliers alone was drawn");
}

void BindScales(ConsensusOptions& o, OptionsBinder& b) {
  b.Field("threshold", o.threshold)
      .Help("what an inlier is: ε as given, or what suits a model's own residuals, with ε the greatest");
  const bool scales = o.Uses(ScoreKind::kMarginalised) || o.final_refinement == FinalRefinement::kMarginalised ||
                      o.threshold == ThresholdKind::kAdaptive;
  b.Field("least_scale", o.least_scale, AtLeast(0.0))
      .OnlyIf(scales, "a score or refinement over scales, or threshold: adaptive")
      .Help("the smallest threshold that these reckon with, in the data's unit; 0: an eighth of the greatest");
  b.Field("greatest_scale", o.greatest_scale, AtLeast(0.0))
      .OnlyIf(scales, "a score or refinement over scales, or threshold: adaptive")
      .Help("the greatest one; 0: the scoring threshold");
  b.Require(o.greatest_scale == 0.0 || o.least_scale < o.greatest_scale, "least_scale", "below greatest_scale");
  b.Field("inlier_prior_power", o.inlier_prior_power, AtLeast(0.0))
      .Help(
          "points count with their probability of being inliers (a network's, or by the ratio) to this power; 0: "
          "alike");
  b.Field("turn_weight", o.turn_weight, Within(0.0, 1.0))
      .Help(
          "epipolar models: a match whose keypoint does not turn as its epipolar lines do counts with this; 1: alike");
  b.Field("camera_prior", o.camera_prior, AtLeast(0.0))
      .Help(
          "F and H, with image sizes: scores are divided by 1 + this · (s₁ − s₂)/s₂ of E, or (s₁ − s₃)/s₂ of H, with a "
          "guessed focal length; unknown focal lengths: by 1 + this · (deviation from the prior in its σ)²");
  b.Field("focal_log_sigma", o.focal_log_sigma, Positive())
      .Help("unknown focal lengths: σ of log f before anything is seen, of images for which the data gives none");
}

void BindRefits(ConsensusOptions& o, OptionsBinder& b) {
  b.Field("refit_rounds", o.refit_rounds, AtLeast(1))
      .OnlyIf(o.refit == Refit::kIterated, "refit: iterated")
      .Help("least squares each, at most");
  b.Field("refit_threshold_factor", o.refit_threshold_factor, Positive())
      .OnlyIf(o.refit != Refit::kNone && o.refit != Refit::kMixture, "refit: inliers, iterated or irls")
      .Help("the refit's inlier threshold as a multiple of ε (irls: of the score's)");
  b.Field("sigma_prior", o.sigma_prior, AtLeast(0.0))
      .OnlyIf(o.refit == Refit::kMixture, "refit: em")
      .Help("σ is estimated in a last refit, where the assumed one counts as so many inliers; 0: it stays");
  b.Field("refit_candidates", o.refit_candidates, Within(1, 1e4))
      .Help("how many of the best distinct hypotheses are refitted; the final score chooses");
  const bool optimised = o.local_optimization != LocalOptimization::kNone;
  b.Field("basins", o.basins, Within(0, 1e4))
      .OnlyIf(optimised, "a local_optimization")
      .Help("so many of the best draws that differ are optimised locally after the search, unless it ended confident");
  b.Field("polish", o.polish, Within(0, 1e4))
      .OnlyIf(optimised, "a local_optimization")
      .Help(
          "there as well: the chosen model is optimised locally so many times more, from other samples of its inliers");
  b.Field("refine_finalists", o.refine_finalists, Within(0, 1e4))
      .OnlyIf(o.final_refinement != FinalRefinement::kNone, "final_refinement: lm or lm_marginalised")
      .Help("all candidates are refitted once and refined by a few steps, and so many of them to the end; 0: all");
}

}  // namespace

void ConsensusOptions::Bind(OptionsBinder& b) {
  b.Field("score", score).Help("chooses among hypotheses");
  b.Field("final_score", final_score)
      .Help("chooses among refitted candidates; gaussian_uniform then estimates the share of inliers");
  b.Field("local_optimization", local_optimization).Help("of each new best minimal model, kept where it scores higher");
  b.Field("refit", refit).Help("after the search");
  b.Field("final_refinement", final_refinement)
      .Help("of each refitted candidate; lm: the model's own nonlinear refinement, kept unless the final score falls");
  b.Field("score_threshold_factor", score_threshold_factor, Positive())
      .Help("scoring threshold as a multiple of the inlier threshold ε");

  const bool reweighted = local_optimization == LocalOptimization::kReweighted || refit == Refit::kReweighted;
  const bool graph_cut = local_optimization == LocalOptimization::kGraphCut;
  b.Field("residual_dof", residual_dof, Within(0, 6))
      .OnlyIf(Uses(ScoreKind::kMagsac) || reweighted, "magsac_pp as a score or irls")
      .Help("degrees of freedom of a residual for MAGSAC++; 0: the model's own");
  BindScales(*this, b);
  b.Field("sigma_factor", sigma_factor, Positive())
      .OnlyIf(Uses(ScoreKind::kGaussianUniform) || refit == Refit::kMixture, "gaussian_uniform as a score or refit: em")
      .Help("σ of inlier noise as a multiple of ε");
  b.Field("inlier_prior", inlier_prior, Within(0.001, 0.999))
      .OnlyIf(Uses(ScoreKind::kGaussianUniform), "gaussian_uniform as a score")
      .Help("share of inliers that the score assumes during the search");
  b.Field("local_samples", local_samples, AtLeast(0))
      .OnlyIf(graph_cut || local_optimization == LocalOptimization::kInnerSamples,
              "local_optimization: lo_ransac or gc_ransac")
      .Help("inner samples each time");
  b.Field("irls_rounds", irls_rounds, AtLeast(1)).OnlyIf(reweighted, "irls").Help("reweighted fits each time, at most");
  b.Field("graph_neighbors", graph_neighbors, Within(1, 1000))
      .OnlyIf(graph_cut, "local_optimization: gc_ransac")
      .Help("nearest points that should agree");
  b.Field("spatial_weight", spatial_weight, Within(0.0, 1e3))
      .OnlyIf(graph_cut, "local_optimization: gc_ransac")
      .Help("λ, the weight of their agreement");

  BindStopping(*this, b);
  BindRefits(*this, b);
  b.Field("block_size", block_size, Within(0, 1e6))
      .Help("sets drawn and scored at a time, 0: from 64 growing to 4096; results do not depend on it");
}

}  // namespace diffsac
