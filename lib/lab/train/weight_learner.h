#pragma once

#include <memory>

#include "lab/options/options.h"
#include "lab/torch/weighted_estimator.h"
#include "lab/train/network_learner.h"

namespace diffsac {

/// What a method whose network weighs points has for itself in a training configuration: its network, how its weights
/// are used, and a group by the method's name with what its loss needs. Network: see MakeLearnedWeights; Own: that
/// group, a struct with `Bind` and `kHelp`.
template <class Network, class Own>
struct WeightTraining : LearnerOptions {
  typename Network::Options network;
  Own learning;
  WeightedEstimatorOptions inference = DefaultWeightedOptions(Network::kMethod);

  explicit WeightTraining(Task) {}
  const PointFeaturesOptions& features() const override { return network.features; }
  void Bind(OptionsBinder& b) override {
    b.Field("network", network).Help("what must be the same in training and in inference");
    b.Field(Network::kMethod, learning).Help(Own::kHelp);
    b.Field("inference", inference).Help("how the weights are used");
    inference.model = model;
  }
};

/// The learner of such a method, but for its loss.
template <class Network, class Own>
class WeightLearner : public NetworkLearner<LearnedWeights, WeightedEstimator, WeightTraining<Network, Own>> {
 public:
  using Training = WeightTraining<Network, Own>;
  WeightLearner(const TrainConfig& options, const Training& own, const torch::Device& device, int threads)
      : NetworkLearner<LearnedWeights, WeightedEstimator, Training>(
            options, own, device, threads,
            [&](Task task, const Rng& rng) { return MakeLearnedWeights<Network>(task, own.network, rng); }) {}
};

}  // namespace diffsac
