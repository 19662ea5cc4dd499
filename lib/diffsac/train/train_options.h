#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/data/labels.h"
#include "diffsac/eval/metrics.h"
#include "diffsac/methods/clnet.h"
#include "diffsac/methods/diffsac_network.h"
#include "diffsac/methods/diffsac_options.h"
#include "diffsac/methods/ng_ransac.h"
#include "diffsac/methods/weighted_method.h"
#include "diffsac/train/training_source.h"
#include "diffsac/train/weights_options.h"

namespace diffsac {

struct TrainOptions {
  bool diffusion = true;                ///< Of method diffsac, which alone has the keys marked †. No key.
  std::int64_t iterations = 20000;      ///< optimiser steps
  int batch_size = 64;                  ///< problems a step
  int noise_copies = 4;  ///< † draws of (label, t, noise) for each problem; the encoder runs once for them
  double learning_rate = 1e-4;          ///< peak; cosine to 0
  std::int64_t warmup_iterations = 200;
  double clip_norm = 1.0;               ///< largest gradient norm; 0 does not clip
  double ema_decay = 0.999;
  double inlier_weight = 1.0;    ///< † weight of the inlier head's cross-entropy beside the diffusion loss
  double positive_weight = 1.0;  ///< † weight of the minimal set's points in the diffusion loss
  double self_conditioning_probability = 0.5;  ///< †
  std::string precision = "auto";  ///< † "auto" | "float32" | "bfloat16"; auto: bfloat16 on CUDA and CPUs that have it
  std::int64_t log_every = 100;
  std::int64_t validate_every = 1000;
  std::int64_t checkpoint_every = 1000;
  int workers = 1;                      ///< data threads
  /// A checkpoint of the same architecture, of any task, whose averaged weights training starts from. Empty: none.
  std::string start_from;
  TwoViewTrainingOptions two_view;
  std::uint64_t seed = 1;
  void Bind(OptionsBinder& b);

 private:
  void BindDiffusion(OptionsBinder& b);
};

/// The key `validation.data` holds what its data changes in the training data, or, with a `type`, other data altogether;
/// a mixture is validated on its first part unless there is such data. Generated data is of split "validation".
struct ValidationOptions {
  int problems = 256;                            ///< for each group; fewer when there are fewer
  std::vector<double> outlier_ratios = {0.5, 0.7, 0.8};  ///< a group each; empty: one group of the data as it is
  double threshold_deg = 0.5;                    ///< mAA threshold
  double threshold_px = 20.0;                    ///< the same for homographies
  Tolerance ToleranceOf(Task task) const {
    return ErrorInPixels(task) ? Tolerance(threshold_px, true) : Tolerance(threshold_deg);
  }
  void Bind(OptionsBinder& b);
};

/// A whole training configuration (configs/line.yaml).
struct TrainConfig {
  std::string name = "run";
  /// "diffsac" | "ng_ransac" | "clnet": what is learned. `network` and `inference` are that method's; the others than
  /// diffsac have no `labels` but a group of their own name.
  std::string method = "diffsac";
  std::string task = "line";
  /// By which of the task's models minimal sets are solved: those of labels, of training and of inference; empty: the
  /// task's own. Of task fundamental also fundamental8.
  std::string model;
  NetworkOptions network;
  LabelOptions labels;
  TrainOptions train;
  ValidationOptions validation;
  DiffsacOptions inference;
  NgRansacNetworkOptions ng_ransac_network;
  NgRansacTraining ng_ransac;
  ClnetNetworkOptions clnet_network;
  ClnetTraining clnet;
  WeightedMethodOptions weighted_inference;  ///< of ng_ransac and clnet
  /// The features of the method's network.
  const PointFeaturesOptions& Features() const;
  /// The key `data` is the dataset factory's.
  void Bind(OptionsBinder& b);
};

/// Reads a configuration. Two views are validated in one group, at 10 degrees, unless it says otherwise. Throws Error.
TrainConfig ReadTrainConfig(const Config& config);

/// The resolved configuration as YAML, defaults included.
std::string ResolvedConfig(const TrainConfig& options, const Config& config);

}  // namespace diffsac
