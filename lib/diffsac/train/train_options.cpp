#include "diffsac/train/train_options.h"

#include <sstream>

#include "diffsac/data/dataset_factory.h"

namespace diffsac {

void TrainOptions::Bind(OptionsBinder& b) {
  b.Field("iterations", iterations, AtLeast(1));
  b.Field("batch_size", batch_size, AtLeast(1));
  b.Field("noise_copies", noise_copies, AtLeast(1));
  b.Field("learning_rate", learning_rate, Positive());
  b.Field("warmup_iterations", warmup_iterations, AtLeast(0));
  b.Field("clip_norm", clip_norm, AtLeast(0));
  b.Field("ema_decay", ema_decay, Within(0.0, 1.0));
  b.Field("inlier_weight", inlier_weight, AtLeast(0));
  b.Field("positive_weight", positive_weight, Positive());
  b.Field("self_conditioning_probability", self_conditioning_probability, Within(0.0, 1.0));
  b.Choice("precision", precision, {"auto", "float32", "bfloat16"});
  b.Field("log_every", log_every, AtLeast(1));
  b.Field("validate_every", validate_every, AtLeast(1));
  b.Field("checkpoint_every", checkpoint_every, AtLeast(1));
  b.Field("workers", workers, Within(1, 256));
  b.Field("seed", seed);
}

void ValidationOptions::Bind(OptionsBinder& b) {
  b.Field("problems", problems, AtLeast(1));
  b.Field("outlier_ratios", outlier_ratios, Within(0.0, 0.99));
  b.Field("threshold_deg", threshold_deg, Positive());
}

void TrainConfig::Bind(OptionsBinder& b) {
  b.Field("name", name);
  b.Choice("task", task, {"line", "plane"});
  b.Ignore("data");
  b.Group("network", network);
  b.Group("labels", labels);
  b.Group("train", train);
  b.Group("validation", validation);
  b.Group("inference", inference);
}

std::string ResolvedConfig(const TrainConfig& options, const Config& config) {
  std::istringstream data(WriteDatasetOptions(config.Sub("data")));
  std::string text = WriteOptions(options) + "\ndata:\n";
  for (std::string line; std::getline(data, line);) text += "  " + line + "\n";
  return text;
}

}  // namespace diffsac
