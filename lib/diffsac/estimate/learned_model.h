#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "diffsac/core/stored_options.h"
#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/point_features.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// What a learned row must know of its network, whatever computes it.
struct LearnedModel {
  Task task;
  PointFeaturesOptions feature_options;
  PointFeatures features;
  TrainingFacts facts;  ///< Of a loaded network.
  /// Of a problem; the network compares each of them with each.
  int most_points = std::numeric_limits<int>::max();
  /// A batch goes through the network in parts of so many problems, each on one thread, so that the number of threads
  /// changes no bit of what comes out; 0: at once, however many threads the network uses.
  int problems_a_call = 0;
  /// Whether several problems at once take less time than one after the other.
  bool batches = true;

  LearnedModel(Task task_value, const PointFeaturesOptions& options)
      : task(task_value), feature_options(options), features(options, task_value) {}
};

/// The training configuration that a checkpoint carries, read once for all who ask for something of it.
struct TrainedConfig {
  std::string checkpoint;  ///< Its file.
  std::string method;      ///< That trained it.
  Task task{};
  std::string config;  ///< JSON.
  std::string model;   ///< By which of the task's models its minimal sets are solved; empty: the task's own.
  std::uint64_t seed = 0;
  TrainingFacts facts;  ///< Without the number of parameters, which the network knows.
};

/// A group of the configuration. Throws Error as StoredOptions does.
StoredOptions GroupOf(const TrainedConfig& trained, const char* key);
/// Throws Error naming the file when it is no checkpoint.
TrainedConfig ReadTrainedConfig(const std::string& checkpoint);
/// Throws Error naming the file when it was trained by another method or for another task.
void CheckTrainedFor(const TrainedConfig& trained, const std::string& method, Task task);
/// Both.
TrainedConfig ReadTrainedConfig(const std::string& checkpoint, const std::string& method, Task task);

}  // namespace diffsac
