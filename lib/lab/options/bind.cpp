#include <algorithm>

#include "diffsac/core/nearest_word.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/diffsac_options.h"
#include "diffsac/guidance/diffusion/reverse_sampler.h"
#include "diffsac/guidance/engine/network_options.h"
#include "diffsac/guidance/engine/set_scorer.h"
#include "diffsac/problem/tasks.h"
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

void BindOptions(OptionsBinder& b, PointFeaturesOptions& o) {
  b.Field("kinds", o.kinds)
      .Help("their columns stand side by side; ratios, neighborhoods, descriptors and similarities are for two views");
  const bool descriptors = o.Has(PointFeature::kDescriptors), residual = o.Has(PointFeature::kResidual);
  b.Field("use_calibration", o.use_calibration)
      .OnlyIf(o.kinds != std::vector{PointFeature::kResidual}, "other kinds than [residual]")
      .Help("coordinates of the calibrated camera where it is known, else by the images' sizes");
  b.Field("descriptor_size", o.descriptor_size, Within(1, 4096))
      .OnlyIf(descriptors, "kinds: [coordinates_descriptors]")
      .Help("values of one descriptor (128 for SIFT: the paper's 260 columns)");
  b.Field("descriptors_required", o.descriptors_required)
      .OnlyIf(descriptors, "kinds: [coordinates_descriptors]")
      .Help("a problem without descriptors is an error; else its columns are 0");
  b.Field("residual_draws", o.residual_draws, Within(1, 1e5))
      .OnlyIf(residual, "kinds: [residual]")
      .Help("minimal sets that are drawn");
  b.Field("residual_kept", o.residual_kept, Within(1, 4096))
      .OnlyIf(residual, "kinds: [residual]")
      .Help("how many of the best-scored are kept as columns");
  b.Field("residual_from", o.residual_from)
      .OnlyIf(residual, "kinds: [residual]")
      .Help("`napsac`: a point and its neighbours, for structures that lie apart");
  b.Field("residual_choice", o.residual_choice)
      .OnlyIf(residual, "kinds: [residual]")
      .Help("`spread`: each adds most to what the earlier ones explain, so that no structure takes all columns");
  b.Require(!o.kinds.empty(), "kinds",
            "at least one of coordinates, coordinates_ratio, neighborhood, coordinates_descriptors, similarity, "
            "residual");
}

void BindOptions(OptionsBinder& b, NoiseScheduleOptions& o) {
  b.Field("kind", o.kind)
      .Help(
          "`cosine`; `linear`, made for T = 1000: with T = 100 the last step still shows the labels, so it warns; "
          "`linear_scaled`: linear with both ends times 1000/T");
  const bool linear = o.kind != NoiseScheduleKind::kCosine;
  b.Field("steps", o.steps, Within(1, 1e5)).Help("T");
  b.Field("beta_start", o.beta_start, {0.0, 0.999, true})
      .OnlyIf(linear, "kind: linear or linear_scaled")
      .Help("first β, before scaling");
  b.Field("beta_end", o.beta_end, {0.0, 0.999, true})
      .OnlyIf(linear, "kind: linear or linear_scaled")
      .Help("last β, before scaling");
  b.Field("zero_terminal_snr", o.zero_terminal_snr)
      .Help("shift and scale √ᾱ so that ᾱ_T = 0 and ᾱ_1 stays (Lin et al., WACV 2024)");
  b.Require(o.beta_end >= o.beta_start, "beta_end", "at least beta_start");
  b.Require(o.kind != NoiseScheduleKind::kLinearScaled || 1000.0 / o.steps * o.beta_end < 1.0, "steps",
            "more steps for linear_scaled, so that beta_end * 1000 / steps is below 1");
  b.Require(!o.zero_terminal_snr || o.steps >= 2, "steps", "at least 2 with zero_terminal_snr");
}

void BindOptions(OptionsBinder& b, ReverseSamplerOptions& o) {
  b.Field("kind", o.kind)
      .Help(
          "`renoise`: the update in the paper's text (multistep consistency sampling); `dpm_solver_pp`: as in the "
          "paper's experiments");
  b.Field("steps", o.steps, Within(1, 1e5)).Help("at most the schedule's T; `ddpm` as published takes all T");
  const bool dpm = o.kind == ReverseSamplerKind::kDpmSolverPp;
  b.Field("order", o.order, Within(1, 2)).OnlyIf(dpm, "kind: dpm_solver_pp").Help("of the solver; 2: multistep (2M)");
}

void BindOptions(OptionsBinder& b, DenoiserOptions& o) {
  b.Field("kind", o.kind)
      .Help(
          "`point_transformer`: the paper's; `pooled`: point-wise layers with pooled context, for CPUs; `mlp`, "
          "`dgcnn`: of the paper's ablation");
  const bool transformer = o.kind == DenoiserKind::kPointTransformer;
  b.Field("width", o.width, Within(8, 4096)).Help("channels of a point");
  b.Field("heads", o.heads, Within(1, 64)).OnlyIf(transformer, "kind: point_transformer").Help("attention heads");
  b.Field("encoder_layers", o.encoder_layers, Within(0, 64))
      .Help("blocks before c_t enters, computed once a problem; 0 is the paper's joint network");
  b.Field("layers", o.layers, Within(1, 64)).Help("blocks after c_t has entered, computed for each copy and step");
  b.Field("neighbors", o.neighbors, Within(1, 1024))
      .OnlyIf(o.kind == DenoiserKind::kDgcnn, "kind: dgcnn")
      .Help("of a point");
  b.Field("inlier_head", o.inlier_head)
      .Help("a second output: each point's inlier probability, for the learned refit and the inlier head's sets");
  b.Field("relation", o.relation)
      .Help(
          "each point also sees how much it agrees with points that are confident now; needs features.kinds: "
          "[residual]");
  b.Require(o.width % 2 == 0, "width", "an even number");
  b.Require(!transformer || o.width % o.heads == 0, "heads", "a divisor of width");
  b.Require(!o.inlier_head || o.encoder_layers > 0, "inlier_head",
            "false when encoder_layers is 0 (nothing to read it from)");
}

void BindOptions(OptionsBinder& b, NetworkOptions& o) {
  b.Field("features", o.features).Help("what the network sees of a point");
  b.Field("denoiser", o.denoiser).Help("the network's layers");
  b.Field("schedule", o.schedule).Help("the forward process");
  b.Field("loss", o.loss)
      .Help("`mse`: the network's output is ĉ_0 (Algorithm 1); `bce`: it is the logit of \"c_0 = +1\"");
  b.Field("direct", o.direct).Help("no diffusion: predicts c_0 from the points at once");
}

void BindOptions(OptionsBinder& b, SetScorerOptions& o) {
  b.Field("width", o.width, Within(4, 1024)).Help("channels of a hypothesis");
  b.Field("heads", o.heads, Within(1, 64)).Help("of attention");
  b.Field("layers", o.layers, Within(1, 64)).Help("of attention and a point-wise network each");
  b.Field("hidden", o.hidden, Within(1, 4096)).Help("channels within the latter");
  b.Field("pair_width", o.pair_width, Within(1, 1024))
      .Help("channels between the features of two hypotheses and what they add to their attention");
  b.Require(o.width % o.heads == 0, "heads", "a divisor of `width`");
}

namespace {

// For the documentation: "Of `fundamental`: fundamental or fundamental8".
std::string TasksWithSeveral() {
  std::string text;
  for (const std::string& task : TaskNames())
    if (const auto names = ModelNames(TaskFromString(task)); names.size() > 1)
      text += (text.empty() ? "Of `" : "; of `") + task + "`: " + OneOf(names);
  return text;
}

/// What every search has, with a network or without.
template <class Options>
void BindSearch(OptionsBinder& b, Options& o) {
  b.Field("consensus", o.consensus).Help("score, local optimisation, stopping and refits");
  b.Field("instances", o.instances).Help("whether several models are looked for, and how");
  b.Field("search_again", o.search_again).Help("whether a first search that leaves doubts is followed by a second one");
  b.Field("photographs", o.photographs)
      .Help("F, images of equal sizes: of one camera with square pixels and a usual focal length");
}

}  // namespace

void BindModel(OptionsBinder& b, Task task, std::string* model) {
  const std::vector<std::string> names = ModelNames(task);
  b.Field("model", *model)
      .Help("by which of the task's models minimal sets are solved; empty: its own. " + TasksWithSeveral());
  b.Require(model->empty() || std::find(names.begin(), names.end(), *model) != names.end(), "model",
            OneOf(names) + " for task " + ToString(task));
}

void BindOptions(OptionsBinder& b, ClassicalOptions& o) {
  b.Field("max_iterations", o.max_iterations, Within(1, 1e7))
      .Help("minimal sets: exactly so many, at most with stopping: confidence");
  b.Field("sampling", o.sampling).Help("what draws minimal sets");
  o.consensus.max_iterations = o.max_iterations;
  BindSearch(b, o);
  b.Require(o.consensus.max_iterations <= o.max_iterations, "consensus.max_iterations", "at most `max_iterations`");
  // One budget: so a setting that says how many draws means the same to this row and to one with a network.
  o.max_iterations = o.consensus.max_iterations;
  b.Require(o.consensus.stopping == Stopping::kBudget || o.consensus.min_iterations <= o.max_iterations,
            "consensus.min_iterations", "at most `max_iterations`");
}

void BindShared(OptionsBinder& b, LearnedOptions& o) {
  b.Field("feature_hypotheses", o.feature_hypotheses)
      .Help("score the hypotheses that the features were made from as well");
  b.Field("residual_draws", o.residual_draws, Within(0, 1e5))
      .Help("minimal sets of the residual features; 0: as in training");
  b.Field("batch", o.batch, Within(1, 4096)).Help("problems a network call");
  BindSearch(b, o);
  b.Field("inlier_prior_of", o.inlier_prior_of)
      .OnlyIf(o.consensus.inlier_prior_power > 0.0, "consensus.inlier_prior_power above 0")
      .Help("whose probabilities weigh the points in scores; both: their geometric mean");
}

void BindOptions(OptionsBinder& b, DiffsacOptions& o) {
  b.Field("num_diffusion_samples", o.num_diffusion_samples, Within(0, 10000))
      .Help("κ: copies of the reverse process, and minimal sets; 0: the inlier head alone");
  const bool diffusion = o.num_diffusion_samples > 0;
  const char* by_diffusion = "num_diffusion_samples above 0";
  b.Field("sampler", o.sampler)
      .OnlyIf(diffusion, by_diffusion)
      .Help("which reverse process, and how many network steps");
  b.Field("selection", o.selection)
      .OnlyIf(diffusion || o.selection == SetSelection::kGumbel, by_diffusion)
      .Help(
          "maximum: top-γ; probabilistic: drawn by softmax(confidence / temperature); gumbel: in proportion to "
          "p^(1/temperature), p = (1 + confidence) / 2, as the inlier head's sets always are");
  b.Field("num_guided_samples", o.num_guided_samples, Within(0, 10000))
      .Help("sets from the inlier head, after those of the copies");
  b.Require(diffusion || o.num_guided_samples > 0, "num_diffusion_samples",
            "at least 1, or num_guided_samples above 0");
  b.Field("draws_by", o.draws_by)
      .OnlyIf(o.num_guided_samples > 0, "num_guided_samples above 0")
      .Help("by whose probabilities the inlier head's sets are drawn; both also orders PROSAC's");
  const bool drawn = o.selection != SetSelection::kMaximum || o.num_guided_samples > 0;
  b.Field("temperature", o.temperature, Positive())
      .OnlyIf(drawn, "selection: probabilistic or gumbel, or sets from the inlier head")
      .Help(
          "of drawn sets; [first, last]: copies go from one to the other in equal ratios, the inlier head's sets "
          "through ten such");
  b.Field("num_uniform_samples", o.num_uniform_samples, Within(0, 1000000))
      .Help("so many sets more from another sampler, after the others");
  b.Field("extra_sampler", o.extra_sampler, {MinimalSamplerKind::kUniform, MinimalSamplerKind::kProsac})
      .OnlyIf(o.num_uniform_samples > 0, "num_uniform_samples above 0")
      .Help("prosac samples uniformly on data without matching ratios");
  const bool may_lack = diffusion && o.unique_sets && o.selection == SetSelection::kMaximum;
  b.Field("intermediate_sets", o.intermediate_sets)
      .OnlyIf(may_lack || !o.intermediate_sets, "num_diffusion_samples above 0 and selection: maximum")
      .Help("where the copies have no new set, predictions of earlier reverse steps follow");
  b.Field("learned_refit", o.weighted_fit)
      .Help("add one weighted least-squares hypothesis with the network's inlier probabilities as weights");
  b.Field("max_decoded_points", o.max_decoded_points, AtLeast(0))
      .OnlyIf(diffusion || o.max_decoded_points == 0, by_diffusion)
      .Help("only so many points of highest inlier probability are decoded; 0: all");
  b.Field("max_encoded_points", o.max_encoded_points, AtLeast(0))
      .Help(
          "only so many points that are likely by ratio and neighbourhood, or by the feature hypotheses, go into the "
          "network; 0: all");
  b.Field("engine", o.engine)
      .Help(
          "`fused`: plain C++ on the CPU, for kind: pooled; `libtorch`: every kind and device; `auto`: fused where it "
          "can");
  BindShared(b, o);
  b.Require(o.consensus.stopping == Stopping::kBudget || o.consensus.min_iterations <= o.consensus.max_iterations,
            "consensus.min_iterations", "at most consensus.max_iterations");
}

}  // namespace diffsac
