#pragma once

#include <memory>

#include "lab/train/learner.h"

namespace diffsac {

/// What all learners have in common: a network and, of the same architecture, one for averaged weights, and the row
/// that these are for. Network: a LearnedNetwork; Row: the method that uses it; Own: the method's LearnerOptions, whose
/// `inference` are the row's.
template <class Network, class Row, class Own>
class NetworkLearner : public Learner {
 public:
  torch::nn::Module& network() override { return *network_->module; }
  torch::nn::Module& averaged() override { return *averaged_->module; }
  const PointFeatures& features() const override { return network_->features; }
  std::unique_ptr<RobustEstimator> AveragedEstimator() const override {
    return std::make_unique<Row>(averaged_, own_.inference, threads_);
  }

 protected:
  /// `make` is called once for each network. threads: of estimates in training and validation.
  template <class Make>
  NetworkLearner(const TrainConfig& options, const Own& own, const torch::Device& device, int threads, const Make& make)
      : options_(options),
        own_(own),
        task_(options.task),
        device_(device),
        threads_(threads),
        network_(make(task_, Rng(options.train.seed))),
        averaged_(make(task_, Rng(options.train.seed))) {
    network_->MoveTo(device_);
    averaged_->MoveTo(device_);
    averaged_->module->eval();
  }

  TrainConfig options_;
  Own own_;
  Task task_;
  torch::Device device_;
  int threads_;
  std::shared_ptr<Network> network_;
  std::shared_ptr<Network> averaged_;
};

}  // namespace diffsac
