#pragma once

#include <torch/nn/module.h>
#include <torch/types.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/registry.h"
#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/point_features.h"
#include "lab/train/train_options.h"
#include "lab/train/training_source.h"

namespace diffsac {

/// What differs between learned methods in a training run. Data, schedule, average, checkpoints, resuming and metrics
/// are the trainer's.
class Learner {
 public:
  virtual ~Learner() = default;
  /// The network that is trained, and one of the same architecture for averaged weights; both on the run's device.
  virtual torch::nn::Module& network() = 0;
  virtual torch::nn::Module& averaged() = 0;
  virtual const PointFeatures& features() const = 0;
  /// What the learning rate is multiplied with at a step.
  virtual double RateFactor(std::int64_t) const { return 1.0; }

  struct Loss {
    torch::Tensor total;        ///< what is differentiated, each part times its share
    std::vector<double> parts;  ///< of loss_names, without the shares; NaN for what was not computed
  };
  /// Columns of metrics.csv.
  virtual std::vector<std::string> loss_names() const = 0;
  /// The sum of weights that each part of the loss is a mean over; items weigh the same unless a method says otherwise.
  virtual std::vector<double> LossWeights(const std::vector<TrainingItem>& items) const {
    return std::vector<double>(loss_names().size(), static_cast<double>(items.size()));
  }
  /// Randomness comes from train.seed and the iteration or the items' indices alone (RandomOf). shares: of these items
  /// in what each part of the loss is a mean over (TrainingTeam::Shares), 1 for a process alone.
  virtual Loss Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
                       const std::vector<double>& shares) = 0;
  /// The estimator with the averaged network, for validation; valid as long as the learner.
  virtual std::unique_ptr<RobustEstimator> AveragedEstimator() const = 0;
};

/// A method that learns, registered at the end of its learner's file by a RegisteredLearner.
struct LearnerEntry {
  static constexpr const char* kKind = "method that learns";
  std::string help;  ///< One line for the documentation.
  /// The method's options with the defaults of a task.
  std::function<std::shared_ptr<LearnerOptions>(Task)> make_options;
  std::function<std::unique_ptr<Learner>(const TrainConfig&, const torch::Device&, int threads)> make;
};

/// The learner of options.method. threads: of estimates in training and validation. Throws Error for bad options.
inline std::unique_ptr<Learner> MakeLearner(const TrainConfig& options, const torch::Device& device, int threads) {
  return Registry<LearnerEntry>::Instance().Find(options.method, "method").make(options, device, threads);
}

/// Options: LearnerOptions, made of a task. Own: made of a TrainConfig, its Options, a device and a number of threads.
template <class Options, class Own>
struct RegisteredLearner : Registered<LearnerEntry> {
  RegisteredLearner(const std::string& method, const std::string& help)
      : Registered<LearnerEntry>(method, {help, [](Task task) { return std::make_shared<Options>(task); },
                                          [](const TrainConfig& options, const torch::Device& device, int threads) {
                                            const auto& own = dynamic_cast<const Options&>(*options.learner);
                                            return std::make_unique<Own>(options, own, device, threads);
                                          }}) {}
};

}  // namespace diffsac
