#include "diffsac/networks/weighted_method.h"

#include <torch/torch.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "diffsac/consensus/weighted_source.h"
#include "diffsac/networks/prediction_tensors.h"

namespace diffsac {
namespace {

WeightedMethodOptions WithBudget(WeightedMethodOptions options) {
  options.consensus.max_iterations = std::max(1, options.hypotheses);
  return options;
}

}  // namespace

void WeightedMethodOptions::Bind(OptionsBinder& b) {
  b.Field("hypotheses", hypotheses, Within(0, 1000000))
      .Help(
          "minimal sets drawn with the weights, without replacement within a set; repeated ones are solved as well; "
          "exactly so many, or with consensus.stopping: confidence at most");
  b.Field("weighted_fit", weighted_fit).Help("add one weighted non-minimal fit with the weights of all points");
  BindShared(b);
  b.Require(hypotheses > 0 || weighted_fit, "hypotheses", "at least 1 where weighted_fit is false");
  b.Require(consensus.min_iterations <= hypotheses, "consensus.min_iterations", "at most `hypotheses`");
}

WeightedMethodOptions DefaultWeightedOptions(const std::string& method) {
  WeightedMethodOptions options;
  if (method == "clnet") {
    options.hypotheses = 0;
    options.weighted_fit = true;
  }
  return options;
}

void CheckRow(const Config& row, const WeightedMethodOptions& options, const LearnedWeights& weights) {
  CheckRowKeys(row, {{"consensus.max_iterations", false, "the key hypotheses is the limit"},
                     {"consensus.stopping", options.hypotheses > 0, "there are no sets; see hypotheses", "budget"}});
  CheckSharedKeys(row, weights);
}

WeightedMethod::WeightedMethod(std::shared_ptr<const LearnedWeights> weights, const WeightedMethodOptions& options,
                               int threads)
    : LearnedMethod(weights, WithBudget(options), threads),
      weights_(std::move(weights)),
      hypotheses_(options.hypotheses) {
  CheckOptions(options);
}

void WeightedMethod::Infer(std::span<const SolverSpace>, std::span<const std::uint64_t>,
                           std::span<Prediction> predictions) const {
  const c10::InferenceMode inference;
  weights_->BeginCall();
  const auto batch = BatchOf(predictions, weights_->device);
  SplitWeights(weights_->network->Weights(batch), batch.lengths, predictions);
}

std::unique_ptr<HypothesisSource> WeightedMethod::MakeSource(const Guidance& guide) const {
  if (hypotheses_ == 0) return std::make_unique<SequenceSource>();  // no sets: the weighted fit alone
  const std::vector<double> weights(guide.prediction.weights.begin(), guide.prediction.weights.end());
  return std::make_unique<WeightedSource>(weights, guide.set_size, guide.rng.Fork("minimal_sets"));
}

}  // namespace diffsac
