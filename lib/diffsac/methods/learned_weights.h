#pragma once

#include <memory>
#include <string>

#include "diffsac/core/options.h"
#include "diffsac/data/point_features.h"
#include "diffsac/denoiser/clnet_network.h"
#include "diffsac/denoiser/ng_ransac_network.h"
#include "diffsac/denoiser/weight_network.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// A network of point weights with the features it reads.
struct LearnedWeights {
  Task task;
  PointFeaturesOptions feature_options;
  PointFeatures features;
  std::shared_ptr<WeightNetwork> network;
  torch::Device device = torch::kCPU;
  TrainingFacts facts;  ///< Of a loaded network.

  LearnedWeights(Task task_value, const PointFeaturesOptions& options, std::shared_ptr<WeightNetwork> weights)
      : task(task_value), feature_options(options), features(options, task_value), network(std::move(weights)) {}
  void MoveTo(const torch::Device& device);
};

std::shared_ptr<LearnedWeights> MakeNgRansacWeights(Task task, const NgRansacNetworkOptions& options, Rng rng);
std::shared_ptr<LearnedWeights> MakeClnetWeights(Task task, const ClnetNetworkOptions& options, Rng rng);

/// Reads network options and averaged weights from a checkpoint of `method: ng_ransac` or `clnet`. Throws Error naming
/// the file; also when it was trained by another method or for another task.
std::shared_ptr<LearnedWeights> LoadLearnedWeights(const std::string& method, const std::string& checkpoint, Task task,
                                                   const torch::Device& device);

}  // namespace diffsac
