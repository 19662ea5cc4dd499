#include "diffsac/train/trainer.h"

#include <torch/torch.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/progress.h"
#include "diffsac/core/run_directory.h"
#include "diffsac/data/prefetcher.h"
#include "diffsac/denoiser/checkpoint.h"
#include "diffsac/train/learner.h"
#include "diffsac/train/learning_rate.h"
#include "diffsac/train/metrics_log.h"
#include "diffsac/train/training_source.h"
#include "diffsac/train/validation.h"

namespace diffsac {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

std::string Text(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

class Trainer {
 public:
  Trainer(const TrainRequest& request, const TrainConfig& options);
  TrainOutcome Run(const std::atomic<bool>& stop);

 private:
  double Rate(std::int64_t iteration) const {
    const auto& train = options_.train;
    return learner_->RateFactor(iteration) *
           LearningRate(iteration, train.warmup_iterations, train.iterations, train.learning_rate);
  }
  void Step(const std::vector<TrainingItem>& items, std::int64_t iteration);
  std::vector<double> Validate();
  void Save(const std::string& name, bool with_optimizer);
  void Resume();
  std::string CheckpointPath(const std::string& name) const { return directory_.File("checkpoints/" + name); }

  TrainRequest request_;
  TrainConfig options_;
  Task task_;
  std::string resolved_;
  RunDirectory directory_;
  torch::Device device_;
  std::vector<TrainingPart> parts_;
  std::unique_ptr<Learner> learner_;
  std::unique_ptr<ExponentialMovingAverage> average_;
  std::unique_ptr<torch::optim::Adam> optimizer_;
  std::unique_ptr<Validation> validation_;
  CheckpointInfo info_;
  std::vector<double> loss_sums_;  // of the learner's parts since the last row of metrics
  std::int64_t losses_ = 0;
};

Trainer::Trainer(const TrainRequest& request, const TrainConfig& options)
    : request_(request),
      options_(options),
      task_(TaskFromString(options.task)),
      resolved_(ResolvedConfig(options, request.config)),
      directory_(request.output, "diffsac_train", resolved_, options.train.seed),
      device_(DeviceFromString(request.device)),
      parts_(MakeTrainingParts(request.config.Sub("data"), options.train.seed)) {
  const Task data_task = parts_.front().dataset->task();
  if (data_task != task_)
    throw Error(request.config.Where("data") + ": data of task '" + ToString(data_task) + "', but task is '" +
                options.task + "'");
  std::filesystem::create_directories(directory_.File("checkpoints"));
  torch::set_num_threads(request.threads > 0 ? request.threads : HardwareThreads());
  learner_ = MakeLearner(options, device_, request.threads);
  loss_sums_.assign(learner_->loss_names().size(), 0.0);
  if (!options.train.start_from.empty()) LoadAverage(options.train.start_from, learner_->network());
  average_ = std::make_unique<ExponentialMovingAverage>(learner_->network(), options.train.ema_decay);
  optimizer_ = std::make_unique<torch::optim::Adam>(learner_->network().parameters(),
                                                    torch::optim::AdamOptions(options.train.learning_rate));
  validation_ = std::make_unique<Validation>(task_, request.config, options.validation, options.train.seed);
  info_ = {resolved_, GitRevision(), 0, options.train.seed, -1.0};
  if (request.resume) Resume();
}

void Trainer::Resume() {
  const auto path = CheckpointPath("last.pt");
  const auto info = LoadCheckpoint(path, learner_->network(), average_.get(), optimizer_.get());
  if (info.config != resolved_)
    throw Error(path + ": was trained with another configuration than " + request_.config.Where() +
                "; resume with the same one, or choose another --output");
  info_ = info;
  LogInfo("resuming " + path + " at iteration " + std::to_string(info_.iteration));
}

// best.pt is for inference: without the optimiser's state it is half the size.
void Trainer::Save(const std::string& name, bool with_optimizer) {
  SaveCheckpoint(CheckpointPath(name), info_, learner_->network(), *average_,
                 with_optimizer ? optimizer_.get() : nullptr);
}

void Trainer::Step(const std::vector<TrainingItem>& items, std::int64_t iteration) {
  const auto& train = options_.train;
  const double rate = Rate(iteration);
  for (auto& group : optimizer_->param_groups()) group.options().set_lr(rate);
  optimizer_->zero_grad();
  const auto loss = learner_->Compute(items, iteration);
  if (!std::isfinite(loss.total.item<double>()))
    throw Error("the loss is not finite at iteration " + std::to_string(iteration) + "; the last good checkpoint is " +
                CheckpointPath("last.pt") + " (iteration " + std::to_string(info_.iteration) +
                "). A smaller train.learning_rate may help");
  loss.total.backward();
  if (train.clip_norm > 0) torch::nn::utils::clip_grad_norm_(learner_->network().parameters(), train.clip_norm);
  optimizer_->step();
  average_->Update(learner_->network());
  for (std::size_t i = 0; i < loss_sums_.size(); ++i) loss_sums_[i] += loss.parts[i];
  ++losses_;
}

std::vector<double> Trainer::Validate() {
  average_->CopyTo(learner_->averaged());
  return validation_->Run(*learner_->AveragedMethod());
}

TrainOutcome Trainer::Run(const std::atomic<bool>& stop) {
  const auto& train = options_.train;
  LogInfo("task " + options_.task + ", " + std::to_string(CountParameters(learner_->network())) +
          " parameters, device " + device_.str() + ", " + MachineText());
  std::vector<std::string> columns = learner_->loss_names();
  columns.insert(columns.end(), {"learning_rate", "data_wait_share"});
  columns.insert(columns.end(), validation_->names().begin(), validation_->names().end());
  MetricsLog log(directory_.path(), columns, info_.iteration);

  const TrainingSource source(parts_, learner_->features(), options_.labels, train.two_view, learner_->copies(),
                              learner_->schedule_steps(), train.seed);
  Prefetcher<TrainingItem> items([&source](std::uint64_t index) { return source.Make(index); }, train.workers,
                                 4 * train.batch_size,
                                 static_cast<std::uint64_t>(info_.iteration) * train.batch_size);
  Progress progress("training", train.iterations - info_.iteration);
  auto window_start = std::chrono::steady_clock::now();
  double waited = items.wait_seconds();
  for (std::int64_t iteration = info_.iteration; iteration < train.iterations; ++iteration) {
    if (stop.load()) {
      Save("last.pt", true);
      LogWarning("stopped at iteration " + std::to_string(info_.iteration) + "; continue with --resume");
      return TrainOutcome::kStopped;
    }
    std::vector<TrainingItem> batch;
    for (int b = 0; b < train.batch_size; ++b) batch.push_back(items.Next());
    Step(batch, iteration);
    const std::int64_t done = info_.iteration = iteration + 1;
    const bool last = done == train.iterations;
    std::vector<double> accuracies(validation_->names().size(), kNotANumber);
    if (done % train.validate_every == 0 || last) {
      accuracies = Validate();
      const double mean = std::accumulate(accuracies.begin(), accuracies.end(), 0.0) / accuracies.size();
      if (mean > info_.best_validation) {
        info_.best_validation = mean;
        Save("best.pt", false);
      }
      LogInfo("iteration " + std::to_string(done) + ": validation mAA " + Text("%.4f", mean) + " (best " +
              Text("%.4f", info_.best_validation) + ")");
    }
    if (done % train.log_every == 0 || last) {
      const double seconds =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - window_start).count();
      const double share = seconds > 0 ? (items.wait_seconds() - waited) / seconds : 0.0;
      std::vector<double> row;
      for (double& sum : loss_sums_) row.push_back(std::exchange(sum, 0.0) / losses_);
      row.push_back(Rate(iteration));
      row.push_back(share);
      row.insert(row.end(), accuracies.begin(), accuracies.end());
      log.Append(done, row);
      losses_ = 0;
      window_start = std::chrono::steady_clock::now();
      waited = items.wait_seconds();
    }
    if (done % train.checkpoint_every == 0 || last) Save("last.pt", true);
    if (done % train.validate_every == 0 || last) log.Draw();
    progress.Advance();
  }
  progress.Finish();
  return TrainOutcome::kFinished;
}

}  // namespace

TrainOutcome Train(const TrainRequest& request, const std::atomic<bool>& stop) {
  const auto options = ReadTrainConfig(request.config);
  return Trainer(request, options).Run(stop);
}

}  // namespace diffsac
