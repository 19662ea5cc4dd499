#include "lab/train/train_options.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diffsac/problem/tasks.h"
#include "lab/config/paths.h"
#include "lab/config/yaml.h"
#include "lab/ground_truth/task_truth.h"
#include "lab/train/learner.h"
#include "lab/train/validation.h"

namespace diffsac {
namespace {

// What all else depends on.
struct TrainConfigHead {
  std::string method = "diffsac";
  Task task = Task::kLine;
  Config rest;
  void Bind(OptionsBinder& b) {
    b.Choice("method", method, Registry<LearnerEntry>::Instance().Names());
    b.Field("task", task);
    b.Rest(rest);
  }
};

}  // namespace

void TrainOptions::Bind(OptionsBinder& b, Task task) {
  b.Field("iterations", iterations, AtLeast(1)).Help("optimiser steps; a resumed training may have more");
  b.Field("batch_size", batch_size, Within(1, 65536)).Help("problems a step");
  b.Field("learning_rate", learning_rate, Positive()).Help("peak, reached after the warm-up; cosine to 0");
  b.Field("warmup_iterations", warmup_iterations, AtLeast(0)).Help("steps over which the learning rate grows from 0");
  b.Field("clip_norm", clip_norm, AtLeast(0)).Help("largest gradient norm; 0 does not clip");
  b.Field("ema_decay", ema_decay, Within(0.0, 1.0)).Help("of the average of weights that is validated and kept");
  b.Field("log_every", log_every, AtLeast(1))
      .Help("steps between rows of metrics.csv; each validation has one as well");
  b.Field("validate_every", validate_every, AtLeast(1)).Help("steps between validations");
  b.Field("checkpoint_every", checkpoint_every, AtLeast(1)).Help("steps between checkpoints/last.safetensors");
  b.Field("workers", workers, Within(1, 256)).Help("data threads");
  b.Field("start_from", start_from)
      .Help("a checkpoint of the same architecture, of any task, whose averaged weights training starts from");
  b.Field("two_view", two_view).OnlyIf(IsTwoView(task), "a task of two views").Help("what is done to matches");
  b.Field("seed", seed).Help("of all that is drawn");
}

Tolerance ValidationOptions::ToleranceOf(Task task) const {
  return ErrorInPixels(task) ? Tolerance(threshold_px, true) : Tolerance(threshold_deg);
}

void ValidationOptions::Bind(OptionsBinder& b, Task task) {
  b.Field("problems", problems, Within(1, 1e6)).Help("for each group; fewer, evenly spread, where there are fewer");
  b.Field("outlier_ratios", outlier_ratios, Within(0.0, 0.99))
      .Help("of generated data, a group each; empty: one group of the data as it is");
  b.Field("threshold_deg", threshold_deg, Positive())
      .OnlyIf(!ErrorInPixels(task), "errors in degrees")
      .Help("threshold of the mAA, degrees");
  b.Field("threshold_px", threshold_px, Positive())
      .OnlyIf(ErrorInPixels(task), "errors in pixels")
      .Help("threshold of the mAA, pixels");
  b.Field("data", data)
      .Help(
          "what it changes in the training data (in the first part of a mixture), or, with a `type`, other data "
          "altogether; generated data is of split `validation`");
}

TrainConfig::TrainConfig(const std::string& method_name, Task task_value) : method(method_name), task(task_value) {
  learner = Registry<LearnerEntry>::Instance().Find(method, "method").make_options(task);
  if (!IsTwoView(task)) return;
  // Two views are validated in one group.
  validation.outlier_ratios.clear();
  validation.threshold_deg = 10.0;
}

void TrainConfig::Bind(OptionsBinder& b) {
  b.Field("name", name).Help("of the run and, unless --output says otherwise, of its folder in runs/");
  b.Choice("method", method, Registry<LearnerEntry>::Instance().Names()).Help("what is learned");
  b.Field("task", task).Help("what is estimated");
  BindModel(b, task, &model);
  learner->model = model;
  b.Field("data", data).Help("what it is trained on, see below");
  learner->Bind(b);
  b.GroupWith("train", [this](OptionsBinder& inner) {
     train.Bind(inner, task);
     learner->BindTrain(inner);
   }).Help("how it is trained");
  b.GroupWith("validation", [this](OptionsBinder& inner) {
     validation.Bind(inner, task);
   }).Help("how the best checkpoint is told");
}

TrainConfig ReadTrainConfig(const Config& given) {
  const Config config = WithFoundPaths(given);
  const auto head = ReadOptions<TrainConfigHead>(config);
  TrainConfig options = ReadOptions(config, TrainConfig(head.method, head.task));
  if (!config.Has("data")) options.data = config.Sub("data");  // For messages about what is not there.
  return options;
}

std::string WriteTrainConfig(TrainConfig options) {
  if (options.validation.data) options.validation.data = ConfigFromYaml(WriteTrainingData(ValidationData(options)));
  options.data = ConfigFromYaml(WriteTrainingData(options.data));
  return WriteYaml(options);
}

double LearningRate(std::int64_t step, std::int64_t warmup, std::int64_t total, double peak) {
  if (step < warmup) return peak * static_cast<double>(step + 1) / static_cast<double>(warmup);
  const double span = static_cast<double>(std::max<std::int64_t>(1, total - warmup));
  const double done = std::min(1.0, static_cast<double>(step - warmup) / span);
  return peak * 0.5 * (1.0 + std::cos(std::numbers::pi * done));
}

}  // namespace diffsac
