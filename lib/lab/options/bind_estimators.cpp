#include <algorithm>

#include "diffsac/core/nearest_word.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/diffsac_options.h"
#include "diffsac/problem/tasks.h"
#include "lab/options/options.h"

namespace diffsac {
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
