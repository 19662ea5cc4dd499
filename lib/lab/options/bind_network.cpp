#include "diffsac/guidance/diffusion/reverse_sampler.h"
#include "diffsac/guidance/engine/network_options.h"
#include "diffsac/guidance/engine/set_scorer.h"
#include "lab/options/options.h"

namespace diffsac {

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

}  // namespace diffsac
