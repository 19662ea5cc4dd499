#include "diffsac/methods/diffsac_options.h"

#include "diffsac/core/status.h"

namespace diffsac {

void DiffsacOptions::Bind(OptionsBinder& b) {
  b.Field("copies", copies, Within(1, 10000));
  b.Group("sampler", sampler);
  b.Choice("selection", selection, {"maximum", "probabilistic", "gumbel"});
  b.Field("temperature", temperature, Positive());
  b.Choice("guide", guide, {"diffusion", "inlier_head"});
  b.Field("head_sets", head_sets, Within(0, 10000));
  b.Field("extra_sets", extra_sets, Within(0, 1000000));
  b.Choice("extra_source", extra_source, {"uniform", "prosac"});
  b.Field("unique_sets", unique_sets);
  b.Field("intermediate_sets", intermediate_sets);
  b.Field("learned_refit", weighted_fit);
  b.Field("max_decoded_points", max_decoded_points, AtLeast(0));
  BindShared(b);
}

void CheckOptions(const DiffsacOptions& options, const DiffsacNetwork& network) {
  const auto need_head = [&](bool asked, const char* key) {
    if (asked && !network.options.denoiser.inlier_head)
      throw Error(std::string("inference.") + key +
                  ": the network has no inlier head (network.denoiser.inlier_head is false)");
  };
  need_head(options.weighted_fit, "learned_refit");
  need_head(options.guide == "inlier_head", "guide");
  need_head(options.head_sets > 0, "head_sets");
  need_head(options.max_decoded_points > 0, "max_decoded_points");
  const bool eight = network.task == Task::kFundamental && options.fundamental_points == 8;
  const int set_size = eight ? 8 : MinimalSetSize(network.task);
  if (options.max_decoded_points > 0 && options.max_decoded_points < set_size)
    throw Error("inference.max_decoded_points: expected 0 or at least " + std::to_string(set_size) +
                ", the points of a minimal set");
}

void CheckRow(const Config& row, const DiffsacOptions& options, const DiffsacNetwork& network) {
  const bool diffusion = options.guide == "diffusion";
  const bool top = options.selection == "maximum";
  const bool head = !diffusion || options.head_sets > 0;
  const char* by_diffusion = "it needs guide: diffusion";
  const RowKey keys[] = {
      {"sampler", diffusion && !network.options.direct, "it needs guide: diffusion and a network that was trained with noise"},
      {"selection", diffusion, by_diffusion, "gumbel"},
      {"temperature", !top || head, "it needs selection: probabilistic or gumbel, or sets from the inlier head"},
      {"head_sets", diffusion, by_diffusion, "0"},
      {"extra_source", options.extra_sets > 0, "it needs extra_sets"},
      {"unique_sets", diffusion, by_diffusion, "false"},
      {"intermediate_sets", diffusion && options.UsesEarlierSteps(), "it needs guide: diffusion, selection: maximum and unique_sets",
       "false"},
      {"max_decoded_points", diffusion, by_diffusion, "0"},
  };
  CheckRowKeys(row, keys);
  const bool by_confidence = options.consensus.stopping == Stopping::kConfidence;
  const RowKey limit[] = {{"consensus.max_iterations", by_confidence,
                           "it needs consensus.stopping: confidence; the budget is copies, head_sets and extra_sets"}};
  CheckRowKeys(row, limit);
  CheckSharedKeys(row, options, network);
}

}  // namespace diffsac
