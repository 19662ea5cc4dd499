#include "diffsac/estimate/estimate_options.h"

#include <algorithm>

#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/diffsac_options.h"
#include "diffsac/estimate/require.h"

namespace diffsac {
namespace {

/// Of κ: each copy holds a confidence for every point and step of the reverse process.
constexpr int kMostCopies = 1000;

/// max: the preset's number of samples; returns the one that the options ask for.
int Budget(const EstimateOptions& options, int max) {
  if (options.max_iterations) return *options.max_iterations;
  return std::max(max, options.min_iterations.value_or(0));
}

void ApplyToStopping(const EstimateOptions& options, int budget, ConsensusOptions* consensus) {
  consensus->max_iterations = budget;
  consensus->min_iterations = std::min(options.min_iterations.value_or(consensus->min_iterations), budget);
  consensus->confidence = options.confidence.value_or(consensus->confidence);
}

}  // namespace

void EstimateOptions::Check() const {
  const std::string most = std::to_string(kMostIterations);
  const auto is_count = [](const std::optional<int>& count, int least) {
    return !count || (*count >= least && *count <= kMostIterations);
  };
  Require(is_count(max_iterations, 1), "max_iterations", "from 1 to " + most);
  Require(is_count(min_iterations, 0), "min_iterations", "from 0 to " + most);
  Require(!max_iterations || !min_iterations || *min_iterations <= *max_iterations, "min_iterations",
          "at most max_iterations");
  Require(!confidence || (*confidence > 0.0 && *confidence <= kMostConfidence), "confidence",
          "a probability above 0 and below 1 - 1e-9");
  Require(num_threads >= 0, "num_threads", "0 for all cores, or above");
}

void Apply(const EstimateOptions& options, ClassicalOptions* preset) {
  preset->search_threads = options.num_threads;
  preset->photographs = preset->photographs && options.cameras == Cameras::kPhotographs;
  if (preset->instances.Several()) {
    preset->max_iterations = options.max_iterations.value_or(preset->max_iterations);
    return;
  }
  preset->max_iterations = Budget(options, preset->max_iterations);
  ApplyToStopping(options, preset->max_iterations, &preset->consensus);
}

void Apply(const EstimateOptions& options, DiffsacOptions* preset) {
  preset->search_threads = options.num_threads;
  preset->photographs = preset->photographs && options.cameras == Cameras::kPhotographs;
  const int sets = preset->Sets(), budget = Budget(options, sets);
  if (preset->num_diffusion_samples == sets) {
    preset->num_diffusion_samples = std::min(budget, kMostCopies);
  } else if (budget != sets) {
    preset->num_diffusion_samples = std::min(preset->num_diffusion_samples, budget);
    const int others = budget - preset->num_diffusion_samples;
    preset->num_guided_samples = (others + 1) / 2;
    preset->num_uniform_samples = others / 2;
  }
  ApplyToStopping(options, budget, &preset->consensus);
}

}  // namespace diffsac
