#include "lab/torch/ng_ransac.h"

#include <torch/torch.h>

#include "lab/config/registered_learned_estimator.h"
#include "lab/torch/initialize.h"
#include "lab/torch/weighted_estimator.h"

namespace diffsac {
namespace nn = torch::nn;

void NgRansacNetworkOptions::Bind(OptionsBinder& b) {
  b.Field("features", features).Help("what the network sees of a point");
  b.Field("width", width, Within(4, 4096)).Help("channels");
  b.Field("blocks", blocks, Within(1, 256)).Help("residual blocks of two linear layers each");
  b.Field("output", output).Help("weights in proportion to exp x, or to 1 / (1 + exp −x) as in the official networks");
}

NgRansacNetwork::NgRansacNetwork(const NgRansacNetworkOptions& options, int input_width, Rng rng)
    : kind_(options.output) {
  input_ = register_module("input", MakeLinear({input_width, options.width}, rng.Fork("input")));
  for (int i = 0; i < options.blocks; ++i)
    blocks_.push_back(register_module("block" + std::to_string(i),
                                      std::make_shared<ContextBlock>(options.width, rng.Fork("block", i))));
  // A new network samples uniformly.
  output_ = register_module("output", MakeLinear({options.width, 1}, rng.Fork("output"), LinearStart::kZero));
}

torch::Tensor NgRansacNetwork::LogWeights(const PointBatch& batch) {
  const auto shares = MeanShares(batch.mask, batch.size(), batch.max_points(), batch.features.options());
  auto x = torch::relu(input_(batch.features));
  for (auto& block : blocks_) x = block->Forward(x, shares);
  auto logits = output_(x).squeeze(-1).to(torch::kFloat);
  if (kind_ == NgRansacOutput::kSigmoid) logits = torch::log_sigmoid(logits);
  if (batch.mask.defined()) logits = logits.masked_fill(batch.mask.logical_not(), -1e9);
  return torch::log_softmax(logits, 1);
}

torch::Tensor NgRansacNetwork::Weights(const PointBatch& batch) { return LogWeights(batch).exp(); }

const RegisteredLearnedEstimator<WeightedEstimator, WeightedEstimatorOptions, LearnedWeights> kNgRansac(
    "ng_ransac", "Minimal sets drawn with learned weights (docs/ng_ransac.md).", DefaultWeightedOptions("ng_ransac"),
    LoadWeightsOfRow<NgRansacNetwork>);

}  // namespace diffsac
