#include "diffsac/estimate/diffsac_options.h"

#include <string>
#include <utility>

#include "diffsac/core/status.h"
#include "diffsac/guidance/diffusion/confidence_rows.h"

namespace diffsac {

// Where a key does not act, the value that switches off what a row inherits may stand there all the same.

void CheckServes(const DiffsacOptions& options, const DiffsacModel& network) {
  const auto require = [](bool ok, const char* expected) {
    if (!ok) throw Error(std::string("inference.") + expected);
  };
  require(options.num_diffusion_samples >= 0 && options.num_guided_samples >= 0 && options.num_uniform_samples >= 0,
          "copies: expected at least 0");
  require(options.num_diffusion_samples > 0 || options.num_guided_samples > 0,
          "copies: expected at least 1, or num_guided_samples above 0");
  require(options.temperature.low > 0.0 && options.temperature.high > 0.0, "temperature: expected a number above 0");
  const auto need_head = [&](bool asked, const char* key) {
    if (asked && !network.options.denoiser.inlier_head)
      throw Error(std::string("inference.") + key +
                  ": the network has no inlier head (network.denoiser.inlier_head is false)");
  };
  need_head(options.weighted_fit, "learned_refit");
  need_head(options.num_guided_samples > 0, "num_guided_samples");
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
