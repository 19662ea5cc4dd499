#include "diffsac/estimators/diffsac_options.h"

#include <string>
#include <utility>

#include "diffsac/core/status.h"
#include "diffsac/network/diffusion/confidence_rows.h"

namespace diffsac {

// Where a key does not act, the value that switches off what a row inherits may stand there all the same.
void DiffsacOptions::Bind(OptionsBinder& b) {
  b.Field("copies", copies, Within(0, 10000))
      .Help("κ: noise vectors of the reverse process, and minimal sets, for each problem; 0: the inlier head alone");
  const bool diffusion = copies > 0;
  const char* by_diffusion = "copies above 0";
  b.Field("sampler", sampler).OnlyIf(diffusion, by_diffusion).Help("which reverse process, and how many network steps");
  b.Field("selection", selection)
      .OnlyIf(diffusion || selection == SetSelection::kGumbel, by_diffusion)
      .Help(
          "maximum: top-γ; probabilistic: γ drawn by softmax(confidence / temperature); gumbel: γ drawn in proportion "
          "to p^(1/temperature), p = (1 + confidence) / 2, as the inlier head's sets always are");
  b.Field("head_sets", head_sets, Within(0, 10000))
      .Help("so many sets from the inlier head, after those of the copies; at least 1 where copies is 0");
  b.Require(diffusion || head_sets > 0, "copies", "at least 1, or head_sets above 0");
  b.Field("draws_by", draws_by)
      .OnlyIf(head_sets > 0, "head_sets above 0")
      .Help(
          "by whose probabilities the inlier head's sets are drawn; both, their geometric mean, also orders PROSAC's");
  const bool drawn = selection != SetSelection::kMaximum || head_sets > 0;
  b.Field("temperature", temperature, Positive())
      .OnlyIf(drawn, "selection: probabilistic or gumbel, or sets from the inlier head")
      .Help(
          "of drawn sets; [first, last]: the copies go from one to the other in equal ratios, the inlier head's sets "
          "through ten such temperatures again and again");
  b.Field("extra_sets", extra_sets, Within(0, 1000000))
      .Help("so many sets more from another sampler, after the others");
  b.Field("extra_sampler", extra_sampler, {MinimalSamplerKind::kUniform, MinimalSamplerKind::kProsac})
      .OnlyIf(extra_sets > 0, "extra_sets above 0")
      .Help("prosac samples uniformly on data without matching ratios");
  b.Field("unique_sets", unique_sets)
      .OnlyIf(diffusion || !unique_sets, by_diffusion)
      .Help("no minimal set of the copies is solved twice");
  const bool may_lack = diffusion && unique_sets && selection == SetSelection::kMaximum;
  b.Field("intermediate_sets", intermediate_sets)
      .OnlyIf(may_lack || !intermediate_sets, "copies above 0, selection: maximum and unique_sets")
      .Help("where the copies have no new set, or go on, predictions of earlier reverse steps follow, latest first");
  b.Field("learned_refit", weighted_fit)
      .Help("add one weighted least-squares hypothesis with the network's inlier probabilities as weights");
  b.Field("max_decoded_points", max_decoded_points, AtLeast(0))
      .OnlyIf(diffusion || max_decoded_points == 0, by_diffusion)
      .Help("decode only this many points of highest inlier probability; 0 decodes all; needs the inlier head");
  b.Field("max_encoded_points", max_encoded_points, AtLeast(0))
      .Help(
          "only so many points that are likely by ratio and neighbourhood (lines and planes: by the feature "
          "hypotheses) go into the network, the others are weighed by that; 0: all");
  b.Field("engine", engine)
      .Help(
          "what computes the network; `fused`: plain C++ on the CPU, one problem a thread, for kind: pooled; "
          "`libtorch`: every kind and device; `auto`: fused where it can");
  BindShared(b);
  b.Require(consensus.stopping == Stopping::kBudget || consensus.min_iterations <= consensus.max_iterations,
            "consensus.min_iterations", "at most consensus.max_iterations");
}

void CheckServes(const DiffsacOptions& options, const DiffsacModel& network) {
  const auto need_head = [&](bool asked, const char* key) {
    if (asked && !network.options.denoiser.inlier_head)
      throw Error(std::string("inference.") + key +
                  ": the network has no inlier head (network.denoiser.inlier_head is false)");
  };
  need_head(options.weighted_fit, "learned_refit");
  need_head(options.head_sets > 0, "head_sets");
  need_head(options.max_decoded_points > 0, "max_decoded_points");
  MakeConfidenceSampler(options.sampler, network.schedule);  // has it so many steps?
  const int set_size = MinimalSetSize(ModelFromString(network.task, options.model));
  for (const auto& [key, count] : {std::pair{"max_decoded_points", options.max_decoded_points},
                                   {"max_encoded_points", options.max_encoded_points}})
    if (count > 0 && count < set_size)
      throw Error(std::string("inference.") + key + ": expected 0 or at least " + std::to_string(set_size) +
                  ", the points of a minimal set");
}

}  // namespace diffsac
