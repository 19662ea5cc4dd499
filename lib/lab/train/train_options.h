#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/problem/point_features.h"
#include "diffsac/problem/problem.h"
#include "lab/eval/metrics.h"
#include "lab/ground_truth/labels.h"
#include "lab/options/options.h"
#include "lab/train/training_source.h"

namespace diffsac {

/// The group `train`, as every method has it.
struct TrainOptions {
  std::int64_t iterations = 20000;
  int batch_size = 64;
  double learning_rate = 1e-4;
  std::int64_t warmup_iterations = 200;
  double clip_norm = 1.0;
  double ema_decay = 0.999;
  std::int64_t log_every = 100;
  std::int64_t validate_every = 1000;
  std::int64_t checkpoint_every = 1000;
  int workers = 1;
  std::string start_from;
  TwoViewTrainingOptions two_view;
  std::uint64_t seed = 1;
  void Bind(OptionsBinder& b, Task task);
};

/// The group `validation`.
struct ValidationOptions {
  int problems = 256;
  std::vector<double> outlier_ratios = {0.5, 0.7, 0.8};
  double threshold_deg = 0.5;
  double threshold_px = 20.0;
  std::optional<Config> data;
  Tolerance ToleranceOf(Task task) const;
  void Bind(OptionsBinder& b, Task task);
};

/// What a method that learns has for itself in a training configuration: the groups `network` and `inference`, others
/// of its own, and keys in `train`. See RegisteredLearner (lab/train/learner.h).
class LearnerOptions {
 public:
  virtual ~LearnerOptions() = default;
  virtual void Bind(OptionsBinder& b) = 0;
  virtual void BindTrain(OptionsBinder&) {}
  /// What its network sees.
  virtual const PointFeaturesOptions& features() const = 0;
  /// Of training items; none unless the method learns them.
  virtual ItemLabels labels() const { return {}; }
  /// The configuration's `model`, set before Bind: by which of the task's models minimal sets are solved, those of
  /// labels, of training and of inference.
  std::string model;
};

/// A whole training configuration (configs/line.yaml). Defaults depend on method and task, which are read first.
struct TrainConfig {
  /// Throws Error for a method that nobody registered.
  TrainConfig(const std::string& method, Task task);

  std::string name = "run";
  std::string method;  ///< What is learned: "diffsac", "ng_ransac", ... (Registry<LearnerEntry>).
  Task task;
  std::string model;  ///< One of the task's models; empty: its own.
  Config data;        ///< The dataset factory's, or a mixture (MakeTrainingParts).
  TrainOptions train;
  ValidationOptions validation;
  std::shared_ptr<LearnerOptions> learner;  ///< Of the method's own type; shared by copies, so not to be changed.
  void Bind(OptionsBinder& b);
};

/// Linear warm-up to `peak` over `warmup` steps, then a half cosine down to 0 at `total` (the paper: cosine annealing).
double LearningRate(std::int64_t step, std::int64_t warmup, std::int64_t total, double peak);

/// Reads a configuration: first `method` and `task`, then the whole with their defaults. Throws Error.
TrainConfig ReadTrainConfig(const Config& config);

/// The resolved configuration as YAML, that of the data included; reads back to the same.
std::string WriteTrainConfig(TrainConfig options);

}  // namespace diffsac
