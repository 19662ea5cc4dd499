#pragma once

#include <memory>
#include <string>

#include "diffsac/estimate/learned_estimator.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "lab/config/make_estimator.h"
#include "lab/options/config.h"
#include "lab/options/options.h"
#include "lab/torch/learned_network.h"
#include "lab/torch/point_batch.h"

namespace diffsac {

/// A network that weighs the points of a problem: the learned part of NG-RANSAC and of CLNet.
///
/// Outputs are equivariant to the order of the points, and a problem's output does not depend on its batch mates.
class WeightNetwork : public torch::nn::Module {
 public:
  /// Weights ≥ 0 [B, N], 0 for padding.
  virtual torch::Tensor Weights(const PointBatch& batch) = 0;
};

using LearnedWeights = LearnedNetwork<LearnedModel, WeightNetwork>;

/// New weights. Network: made of its `Options`, whose group `features` says what it reads, the number of columns of
/// those and a generator; `kMethod` names the method that it is of.
template <class Network>
std::shared_ptr<LearnedWeights> MakeLearnedWeights(Task task, const typename Network::Options& options, Rng rng) {
  auto weights = std::make_shared<LearnedWeights>(task, options.features);
  weights->module = std::make_shared<Network>(options, weights->features.width(), rng);
  if constexpr (requires { Network::kMostPoints; }) weights->most_points = Network::kMostPoints;
  return weights;
}

/// Those of a checkpoint that Network's method trained. Throws Error naming the file.
template <class Network>
std::shared_ptr<LearnedWeights> LoadLearnedWeights(const TrainedConfig& trained, const torch::Device& device) {
  const auto options = ReadStoredOptions<typename Network::Options>(ConfigOf(trained).Sub("network"));
  RequireWeights(trained.checkpoint, options.LeastWeights());
  auto weights = MakeLearnedWeights<Network>(trained.task, options, Rng(trained.seed));
  weights->Load(trained, device);
  return weights;
}

/// The same for a row (lab/config/registered_learned_estimator.h).
template <class Network>
std::shared_ptr<const LearnedWeights> LoadWeightsOfRow(const TrainedConfig& trained, const LearnedOptions&,
                                                       const EstimatorContext& context) {
  return LoadLearnedWeights<Network>(trained, DeviceFromString(context.device));
}

}  // namespace diffsac
