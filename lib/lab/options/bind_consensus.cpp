#include "diffsac/ransac/instances/instances.h"
#include "diffsac/ransac/option_names.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

void BindStopping(OptionsBinder& b, ConsensusOptions& o) {
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

void BindScales(OptionsBinder& b, ConsensusOptions& o) {
  b.Field("threshold", o.threshold)
      .Help("what an inlier is: ε as given, or what suits a model's own residuals, with ε the greatest");
  const bool scales = o.Uses(ScoreKind::kSigmaMarginalisedMsac) ||
                      o.final_refinement == FinalRefinement::kMarginalised || o.threshold == ThresholdKind::kAdaptive;
  b.Field("least_scale", o.least_scale, AtLeast(0.0))
      .OnlyIf(scales, "a score, refinement or threshold over scales")
      .Help("the smallest threshold that these reckon with, in the data's unit; 0: an eighth of the greatest");
  b.Field("greatest_scale", o.greatest_scale, AtLeast(0.0))
      .OnlyIf(scales, "a score, refinement or threshold over scales")
      .Help("the greatest one; 0: the scoring threshold");
  b.Require(o.greatest_scale == 0.0 || o.least_scale < o.greatest_scale, "least_scale", "below greatest_scale");
  b.Field("inlier_prior_power", o.inlier_prior_power, AtLeast(0.0))
      .Help("points count with their probability of being inliers to this power; 0: alike");
  b.Field("keypoint_orientation_weight", o.keypoint_orientation_weight, Within(0.0, 1.0))
      .Help("F, E: a match whose keypoint does not turn as its epipolar lines do counts with this");
  b.Field("camera_prior", o.camera_prior, AtLeast(0.0))
      .Help(
          "scores are divided by 1 + this · what speaks against a usual camera: F, H of known image sizes, unknown "
          "focal lengths (docs/two_view.md)");
  b.Field("focal_log_sigma", o.focal_log_sigma, Positive())
      .Help("unknown focal lengths: σ of log f where the data gives none");
}

void BindRefits(OptionsBinder& b, ConsensusOptions& o) {
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
  b.Field("lo_starts", o.lo_starts, Within(0, 1e4))
      .OnlyIf(optimised, "a local_optimization")
      .Help("so many of the best draws that differ are optimised locally after the search");
  b.Field("lo_restarts", o.lo_restarts, Within(0, 1e4))
      .OnlyIf(optimised, "a local_optimization")
      .Help("so many times more for the chosen model, from other samples of its inliers");
  b.Field("num_finalists", o.num_finalists, Within(0, 1e4))
      .OnlyIf(o.final_refinement != FinalRefinement::kNone, "final_refinement: lm or lm_marginalised")
      .Help("so many candidates are refined to the end, the others by a few steps; 0: all");
}

}  // namespace

void BindOptions(OptionsBinder& b, ConsensusOptions& o) {
  b.Field("score", o.score).Help("chooses among hypotheses");
  b.Field("final_score", o.final_score)
      .Help("chooses among refitted candidates; mlesac then estimates the share of inliers");
  b.Field("local_optimization", o.local_optimization)
      .Help("of each new best minimal model, kept where it scores higher");
  b.Field("refit", o.refit).Help("after the search");
  b.Field("final_refinement", o.final_refinement)
      .Help("of each refitted candidate; lm: the model's own nonlinear refinement, kept unless the final score falls");
  b.Field("score_threshold_factor", o.score_threshold_factor, Positive())
      .Help("scoring threshold as a multiple of the inlier threshold ε");

  const bool reweighted = o.local_optimization == LocalOptimization::kReweighted || o.refit == Refit::kReweighted;
  b.Field("residual_dof", o.residual_dof, Within(0, 6))
      .OnlyIf(o.Uses(ScoreKind::kMagsac) || reweighted, "magsac_pp as a score or irls")
      .Help("degrees of freedom of a residual for MAGSAC++; 0: the model's own");
  BindScales(b, o);
  b.Field("sigma_factor", o.sigma_factor, Positive())
      .OnlyIf(o.Uses(ScoreKind::kMlesac) || o.refit == Refit::kMixture, "mlesac as a score or refit: em")
      .Help("σ of inlier noise as a multiple of ε");

  BindStopping(b, o);
  BindRefits(b, o);
}

void BindOptions(OptionsBinder& b, MinimalSamplerOptions& o) {
  b.Field("sampler", o.sampler)
      .Help(
          "prosac: in the order of matching ratios; weighted: longer segments more often; length_consistency, "
          "length_ratio_consistency: of clouds, matches whose lengths agree, or by one scale");
  b.Field("napsac_neighbors", o.napsac_neighbors, Within(1, 1e5))
      .OnlyIf(o.sampler == MinimalSamplerKind::kNapsac, "sampler: napsac")
      .Help("how many nearest points count as neighbours");
}

void BindOptions(OptionsBinder& b, InstanceSearchOptions& o) {
  b.Field("search", o.search)
      .Help(
          "several: `sequential`, each search on the points that are left; from one pool of hypotheses `at_once`, "
          "`chosen` by a network, `pearl` by an energy of all labels");
  const bool several = o.Several();
  const char* only = "another search than one";
  b.Field("most", o.most, Within(1, 1000)).OnlyIf(several, only).Help("structures that are looked for at most");
  const bool chosen = o.search == InstanceSearch::kChosen, energy = o.search == InstanceSearch::kPearl;
  const char* by_chance = "search: sequential or at_once";
  b.Field("log10_nfa", o.log10_nfa)
      .OnlyIf(several && !chosen && !energy, by_chance)
      .Help("a structure is taken while chance gives fewer than 10 to this power of its like");
  b.Field("least_chance", o.least_chance, Within(0.0, 1.0))
      .OnlyIf(several && !chosen && !energy, by_chance)
      .Help("probability at least that a point anywhere is within ε of a model");
  b.Field("rounds", o.rounds, Within(0, 100))
      .OnlyIf(several && !chosen, "search: sequential, at_once or pearl")
      .Help(
          "of assigning points and refitting models; `pearl`: of drawing within structures, adding, merging and "
          "removing");
  const char* by_energy = "search: pearl";
  b.Field("core", o.core, Within(1e-3, 100.0))
      .OnlyIf(energy, by_energy)
      .Help("the cost of a residual rises from this share of ε on, by its logarithm");
  b.Field("reach", o.reach, Within(1e-3, 1000.0))
      .OnlyIf(energy, by_energy)
      .Help("so many ε from its model a point can be; there it costs 1");
  b.Field("outlier_cost", o.outlier_cost, Within(0.0, 100.0))
      .OnlyIf(energy, by_energy)
      .Help("of a point without a model");
  b.Field("support_weight", o.support_weight, Within(0.0, 100.0))
      .OnlyIf(energy, by_energy)
      .Help("of what the neighbours of a match say for it, added to its cost as an outlier");
  b.Field("instance_cost", o.instance_cost, Within(0.0, 1e6)).OnlyIf(energy, by_energy).Help("of each model");
  b.Field("spatial_weight", o.spatial_weight, Within(0.0, 100.0))
      .OnlyIf(energy, by_energy)
      .Help("cost of two neighbours that have different models");
  b.Field("neighbors", o.neighbors, Within(1, 1000))
      .OnlyIf(energy, by_energy)
      .Help("nearest points, in all coordinates, that are a point's neighbours");
  b.Field("chooser", o.chooser)
      .OnlyIf(chosen, "search: chosen")
      .Help("the file of a network that was trained with `method: structure_chooser`");
  b.Field("least_value", o.least_value, Within(0.0, 1.0))
      .OnlyIf(chosen, "search: chosen")
      .Help("a structure is taken while the chooser expects it to be worth so much; 0: as many as `most`");
  b.Require(!chosen || !o.chooser.empty() || o.chosen_by != nullptr, "chooser", "a file");
}

}  // namespace diffsac
