#pragma once

#include <functional>
#include <memory>

#include "diffsac/methods/weighted_method.h"
#include "diffsac/train/learner.h"

namespace diffsac {

/// What the learners of point weights (`ng_ransac`, `clnet`) have in common: two networks of one architecture, and the
/// row that their weights are for.
class WeightsLearner : public Learner {
 public:
  torch::nn::Module& network() override { return *weights_->network; }
  torch::nn::Module& averaged() override { return *averaged_->network; }
  const PointFeatures& features() const override { return weights_->features; }
  std::unique_ptr<Method> AveragedMethod() const override {
    return std::make_unique<WeightedMethod>(averaged_, options_.weighted_inference, threads_);
  }

 protected:
  /// `make` is called once for each network.
  WeightsLearner(const TrainConfig& options, const torch::Device& device, int threads,
                 const std::function<std::shared_ptr<LearnedWeights>()>& make)
      : options_(options),
        task_(TaskFromString(options.task)),
        device_(device),
        threads_(threads),
        weights_(make()),
        averaged_(make()) {
    weights_->MoveTo(device_);
    averaged_->MoveTo(device_);
    averaged_->network->eval();
  }

  TrainConfig options_;
  Task task_;
  torch::Device device_;
  int threads_;
  std::shared_ptr<LearnedWeights> weights_;
  std::shared_ptr<LearnedWeights> averaged_;
};

}  // namespace diffsac
