#pragma once

#include <memory>

#include "lab/options/options.h"
#include "lab/torch/weighted_estimator.h"
#include "lab/train/learner.h"

namespace diffsac {

/// A learner of a network and, of the same architecture, one for averaged weights, and the row that these are for; what
/// it lacks is its loss. Row: the method that uses the network. Own: the method's LearnerOptions, whose `inference` are
/// the row's and whose Make(task, rng) is the LearnedNetwork.
template <class Row, class Own>
class NetworkLearner : public Learner {
 public:
  using Training = Own;
  /// threads: of estimates in training and validation.
  NetworkLearner(const TrainConfig& options, const Own& own, const torch::Device& device, int threads)
      : options_(options),
        own_(own),
        task_(options.task),
        device_(device),
        threads_(threads),
        network_(own.Make(task_, Rng(options.train.seed))),
        averaged_(own.Make(task_, Rng(options.train.seed))) {
    network_->MoveTo(device_);
    averaged_->MoveTo(device_);
    averaged_->module->eval();
  }
  torch::nn::Module& network() override { return *network_->module; }
  torch::nn::Module& averaged() override { return *averaged_->module; }
  const PointFeatures& features() const override { return network_->features; }
  std::unique_ptr<RobustEstimator> AveragedEstimator() const override {
    return std::make_unique<Row>(averaged_, own_.inference, threads_);
  }

 protected:
  TrainConfig options_;
  Own own_;
  Task task_;
  torch::Device device_;
  int threads_;
  decltype(std::declval<const Own&>().Make(Task{}, Rng())) network_, averaged_;
};

/// What a method whose network weighs points has for itself in a training configuration: its network, how its weights
/// are used, and a group by the method's name with what its loss needs. Network: see MakeLearnedWeights; Learning: that
/// group, a struct with `Bind` and `kHelp`.
template <class Network, class Learning>
struct WeightTraining : LearnerOptions {
  typename Network::Options network;
  Learning learning;
  WeightedEstimatorOptions inference = DefaultWeightedOptions(Network::kMethod);

  explicit WeightTraining(Task) {}
  std::shared_ptr<LearnedWeights> Make(Task task, const Rng& rng) const {
    return MakeLearnedWeights<Network>(task, network, rng);
  }
  const PointFeaturesOptions& features() const override { return network.features; }
  void Bind(OptionsBinder& b) override {
    b.Field("network", network).Help("what must be the same in training and in inference");
    b.Field(Network::kMethod, learning).Help(Learning::kHelp);
    b.Field("inference", inference).Help("how the weights are used");
    inference.model = model;
  }
};

}  // namespace diffsac
