#include "lab/torch/weighted_estimator.h"

#include <torch/torch.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "diffsac/ransac/samplers/weighted_sampler.h"
#include "lab/config/registered_learned_estimator.h"

namespace diffsac {
namespace {

WeightedEstimatorOptions WithBudget(WeightedEstimatorOptions options) {
  options.consensus.max_iterations = std::max(1, options.max_iterations);
  return options;
}

}  // namespace

void WeightedEstimatorOptions::Bind(OptionsBinder& b) {
  b.Field("max_iterations", max_iterations, Within(0, 1000000))
      .Help(
          "minimal sets drawn with the weights, without replacement within a set; repeated ones are solved as well; "
          "exactly so many, or with consensus.stopping: confidence at most");
  b.Field("weighted_fit", weighted_fit).Help("add one weighted non-minimal fit with the weights of all points");
  BindShared(b, *this);
  b.Require(max_iterations > 0 || weighted_fit, "max_iterations", "at least 1 where weighted_fit is false");
  b.Require(consensus.min_iterations <= max_iterations, "consensus.min_iterations", "at most `max_iterations`");
}

WeightedEstimatorOptions DefaultWeightedOptions(const std::string& method) {
  WeightedEstimatorOptions options;
  if (method == "clnet") {
    options.max_iterations = 0;
    options.weighted_fit = true;
  }
  return options;
}

void CheckRow(const Config& row, const WeightedEstimatorOptions& options, const LearnedWeights& weights) {
  CheckRowKeys(row,
               {{"consensus.max_iterations", false, "the key max_iterations is the limit"},
                {"consensus.stopping", options.max_iterations > 0, "there are no sets; see max_iterations", "budget"}});
  CheckSharedKeys(row, weights);
}

WeightedEstimator::WeightedEstimator(std::shared_ptr<const LearnedWeights> weights,
                                     const WeightedEstimatorOptions& options, int threads)
    : LearnedEstimator(weights, std::make_shared<const WeightedEstimatorOptions>(WithBudget(options)), threads),
      weights_(std::move(weights)),
      max_iterations_(options.max_iterations) {
  CheckOptions(options);
}

void WeightedEstimator::Infer(std::span<const NormalizedProblem>, std::span<const std::uint64_t>,
                              std::span<Prediction> predictions) const {
  const c10::InferenceMode inference;
  BeginCall(*weights_);
  std::vector<const FeatureSet*> rows;
  for (const auto& prediction : predictions) rows.push_back(&prediction.features);
  const auto batch = MakePointBatch(rows).To(weights_->device);
  const auto weights = weights_->module->Weights(batch).to(torch::kCPU, torch::kFloat).contiguous();
  for (std::size_t b = 0; b < predictions.size(); ++b) {
    const float* row = weights.data_ptr<float>() + static_cast<std::int64_t>(b) * weights.size(1);
    predictions[b].weights.assign(row, row + batch.lengths[b]);
  }
}

std::unique_ptr<MinimalSampler> WeightedEstimator::MakeSampler(const Guidance& guide) const {
  if (max_iterations_ == 0) return std::make_unique<SequenceSampler>();  // no sets: the weighted fit alone
  const std::vector<double> weights(guide.prediction.weights.begin(), guide.prediction.weights.end());
  return std::make_unique<WeightedSampler>(weights, guide.set_size, guide.rng.Fork("minimal_sets"));
}

}  // namespace diffsac
