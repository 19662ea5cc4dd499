#include "diffsac/train/train_options.h"

#include <algorithm>

#include "diffsac/core/status.h"
#include "diffsac/data/tasks.h"

namespace diffsac {

void TrainOptions::Bind(OptionsBinder& b) {
  b.Field("iterations", iterations, AtLeast(1));
  b.Field("batch_size", batch_size, AtLeast(1));
  if (diffusion) BindDiffusion(b);
  b.Field("learning_rate", learning_rate, Positive());
  b.Field("warmup_iterations", warmup_iterations, AtLeast(0));
  b.Field("clip_norm", clip_norm, AtLeast(0));
  b.Field("ema_decay", ema_decay, Within(0.0, 1.0));
  b.Field("log_every", log_every, AtLeast(1));
  b.Field("validate_every", validate_every, AtLeast(1));
  b.Field("checkpoint_every", checkpoint_every, AtLeast(1));
  b.Field("workers", workers, Within(1, 256));
  b.Field("start_from", start_from);
  b.Group("two_view", two_view);
  b.Field("seed", seed);
}

void TrainOptions::BindDiffusion(OptionsBinder& b) {
  b.Field("noise_copies", noise_copies, AtLeast(1));
  b.Field("inlier_weight", inlier_weight, AtLeast(0));
  b.Field("positive_weight", positive_weight, Positive());
  b.Field("self_conditioning_probability", self_conditioning_probability, Within(0.0, 1.0));
  b.Choice("precision", precision, {"auto", "float32", "bfloat16"});
}

void NgRansacTraining::Bind(OptionsBinder& b) {
  b.Field("initialization_iterations", initialization_iterations, AtLeast(0));
  b.Field("target_sigma", target_sigma, Positive());
  b.Field("rate_factor", rate_factor, Positive());
  b.Field("pools", pools, Within(2, 1000));
  b.Field("hypotheses", hypotheses, Within(1, 100000));
  b.Choice("loss", loss, {"error", "inliers"});
  b.Field("loss_cap", loss_cap, Positive());
}

void ClnetTraining::Bind(OptionsBinder& b) {
  b.Field("temperature", temperature, Positive());
  b.Field("regression_weight", regression_weight, AtLeast(0));
  b.Field("regression_start", regression_start, Within(0.0, 1.0));
}

void ValidationOptions::Bind(OptionsBinder& b) {
  b.Field("problems", problems, AtLeast(1));
  b.Field("outlier_ratios", outlier_ratios, Within(0.0, 0.99));
  b.Field("threshold_deg", threshold_deg, Positive());
  b.Field("threshold_px", threshold_px, Positive());
  b.Ignore("data");
}

void TrainConfig::Bind(OptionsBinder& b) {
  b.Field("name", name);
  b.Choice("method", method, {"diffsac", "ng_ransac", "clnet"});
  b.Choice("task", task, TaskNames());
  BindModel(b, TaskFromString(task), &model);
  b.Ignore("data");
  train.diffusion = method == "diffsac";
  if (method == "diffsac") {
    b.Group("network", network);
    b.Group("labels", labels);
  } else if (method == "ng_ransac") {
    b.Group("network", ng_ransac_network);
    b.Group("ng_ransac", ng_ransac);
  } else {
    b.Group("network", clnet_network);
    b.Group("clnet", clnet);
  }
  b.Group("train", train);
  b.Group("validation", validation);
  if (method == "diffsac")
    b.Group("inference", inference);
  else
    b.Group("inference", weighted_inference);
}

const PointFeaturesOptions& TrainConfig::Features() const {
  if (method == "ng_ransac") return ng_ransac_network.features;
  return method == "clnet" ? clnet_network.features : network.features;
}

TrainConfig ReadTrainConfig(const Config& config) {
  TrainConfig defaults;
  const std::string task = config.Has("task") ? config.Text("task") : defaults.task;
  const auto tasks = TaskNames();
  const bool known = std::find(tasks.begin(), tasks.end(), task) != tasks.end();
  if (known && IsTwoView(TaskFromString(task))) {
    defaults.validation.outlier_ratios.clear();
    defaults.validation.threshold_deg = 10.0;
  }
  if (config.Has("method")) defaults.weighted_inference = DefaultWeightedOptions(config.Text("method"));
  TrainConfig options = ReadOptions<TrainConfig>(config, defaults);
  const auto& kinds = options.Features().kinds;
  const bool preference = std::find(kinds.begin(), kinds.end(), "preference") != kinds.end();
  if (options.train.two_view.augment && preference)
    throw Error(config.Where("train.two_view.augment") +
                ": not for network.features.kinds preference, whose hypotheses are those of the images as they are");
  options.labels.model = options.inference.model = options.weighted_inference.model = options.model;
  return options;
}

std::string ResolvedConfig(const TrainConfig& options, const Config& config) {
  Config resolved = Config::FromString(WriteOptions(options));
  resolved.Set("data=" + WriteTrainingData(config.Sub("data")));
  if (config.Has("validation.data")) resolved.Set("validation.data=" + config.Sub("validation.data").Dump());
  return resolved.Dump();
}

}  // namespace diffsac
