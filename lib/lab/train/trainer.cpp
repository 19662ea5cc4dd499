#include "lab/train/trainer.h"

#include <torch/torch.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "lab/config/progress.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "lab/eval/format.h"
#include "lab/options/config.h"
#include "lab/torch/checkpoint.h"
#include "lab/torch/denoiser.h"
#include "lab/torch/learned_network.h"
#include "lab/train/distributed.h"
#include "lab/train/fused_adam.h"
#include "lab/train/learner.h"
#include "lab/train/metrics_log.h"
#include "lab/train/prefetcher.h"
#include "lab/train/training_folder.h"
#include "lab/train/training_source.h"
#include "lab/train/validation.h"

namespace diffsac {
namespace {

/// Curves between two validations are drawn no sooner than so after the last ones.
constexpr std::chrono::seconds kCurveInterval{20};

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Trainer {
 public:
  explicit Trainer(const TrainRequest& request);
  TrainOutcome Run(const std::atomic<bool>& stop);

 private:
  TrainOutcome RunSteps(const std::atomic<bool>& stop);
  void EndPage() noexcept;
  double Rate(std::int64_t iteration) const {
    const auto& train = options_.train;
    return learner_->RateFactor(iteration) *
           LearningRate(iteration, train.warmup_iterations, train.iterations, train.learning_rate);
  }
  void Step(const std::vector<TrainingItem>& items, std::int64_t iteration);
  /// Nothing where it was told to stop.
  std::optional<std::vector<double>> Validate(const std::atomic<bool>& stop);
  /// Validates, logs and saves what is due after a step; false where it was told to stop before all of that.
  bool Report(std::int64_t iteration, double data_wait_seconds, const std::atomic<bool>& stop);
  std::optional<std::vector<double>> ValidateWhenDue(std::int64_t done, const std::atomic<bool>& stop);
  bool ValidationDue(std::int64_t done) const {
    return done % options_.train.validate_every == 0 || done == options_.train.iterations;
  }
  TrainOutcome Stop();
  void AppendRow(std::int64_t iteration, double data_wait_seconds, const std::vector<double>& accuracies);
  /// `running`: more is to come.
  void DrawCurves(bool running);
  /// What the progress line says beside the steps.
  std::string ProgressNote() const;
  /// With the validations that are to come.
  double SecondsLeft() const;
  void Save(const std::string& name, bool with_optimizer);
  std::string StoredConfig() const;
  void Resume();
  /// Everything is ready and all processes agree: the run's files become this training's.
  void Begin();
  std::string CheckpointPath(const std::string& name) const { return folder_.Checkpoint(name); }

  TrainConfig options_;
  TrainingTeam team_;
  std::string resolved_;
  TrainingFolder folder_;
  torch::Device device_;
  std::vector<TrainingPart> parts_;
  std::unique_ptr<Learner> learner_;
  std::unique_ptr<ExponentialMovingAverage> average_;
  std::unique_ptr<torch::optim::Adam> optimizer_;
  std::unique_ptr<Validation> validation_;
  CheckpointInfo info_;
  // Of the process that writes:
  std::optional<MetricsLog> log_;
  std::chrono::steady_clock::time_point window_start_;  // the time of the last row of metrics
  double waited_ = 0.0;                                 // for data, until then
  std::chrono::steady_clock::time_point drawn_;         // the time of the last curves
  double shown_loss_ = kNotMeasured;                    // a running mean
  double last_validation_ = kNotMeasured;
  std::optional<Progress> progress_;
  double step_seconds_ = 0.0;  // of `steps_`, those of this process
  std::int64_t steps_ = 0;
  double validation_seconds_ = 0.0;  // of a whole one, by the last problems that were timed
};

Trainer::Trainer(const TrainRequest& request)
    : options_(request.options),
      team_(request.group, options_.train.batch_size),
      resolved_(WriteTrainConfig(options_)),
      folder_(request),
      device_(DeviceFromString(team_.Device(request.device))),
      parts_(MakeTrainingParts(options_.data, options_.train.seed)) {
  const Task data_task = parts_.front().dataset->task();
  if (data_task != options_.task)
    throw Error(options_.data.Where() + ": data of task '" + ToString(data_task) + "', but task is '" +
                ToString(options_.task) + "'");
  torch::set_num_threads(request.threads > 0 ? request.threads : team_.threads());
  learner_ = MakeLearner(options_, device_, request.threads);
  const auto& train = options_.train;
  if (!train.start_from.empty() && !request.resume) LoadAverage(train.start_from, learner_->network());
  average_ = std::make_unique<ExponentialMovingAverage>(learner_->network(), train.ema_decay);
  optimizer_ = std::make_unique<torch::optim::Adam>(learner_->network().parameters(),
                                                    torch::optim::AdamOptions(train.learning_rate));
  if (team_.main()) validation_ = std::make_unique<Validation>(options_);
  info_ = {options_.method, ToString(options_.task), StoredConfig(), GitRevision(), 0, train.seed, -1.0};
  info_.losses.sums.assign(learner_->loss_names().size(), 0.0);
  if (request.resume) Resume();
  team_.CheckSame("configurations", resolved_);
  team_.CheckSame("iterations or weights",
                  std::to_string(info_.iteration) + " " + WeightsText(learner_->network().parameters()));
  if (team_.main()) Begin();
}

// As checkpoints hold it.
std::string Trainer::StoredConfig() const { return ToJson(ConfigFromYaml(resolved_)); }

void Trainer::Resume() {
  const auto path = CheckpointPath("last.safetensors");
  const auto info = LoadCheckpoint(path, learner_->network(), average_.get(), optimizer_.get());
  const std::size_t parts = info_.losses.sums.size();
  info_ = info;
  if (info_.losses.sums.empty()) info_.losses = {std::vector<double>(parts, 0.0), 0};
  if (info_.losses.sums.size() != parts)
    throw Error(path + ": expected the sums of " + std::to_string(parts) + " losses, found " +
                std::to_string(info_.losses.sums.size()));
  LogInfo("resuming " + path + " at iteration " + std::to_string(info_.iteration) +
          (folder_.changes().empty() ? "" : " with " + folder_.changes()));
}

void Trainer::Begin() {
  std::vector<std::string> columns = learner_->loss_names();
  columns.insert(columns.end(), {"learning_rate", "data_wait_share"});
  columns.insert(columns.end(), validation_->names().begin(), validation_->names().end());
  log_.emplace(folder_.path(), columns, info_.iteration);
  folder_.Begin(resolved_);
  // A network of its own from the start, so that a best one beside it can be told from that of a finished run; and what
  // changed is the checkpoint's from here on, so that it says how far this run goes.
  const bool changed = std::exchange(info_.config, StoredConfig()) != StoredConfig();
  if (info_.iteration == 0 || changed) Save("last.safetensors", true);
  log_->Write();
  DrawCurves(true);
}

// best.safetensors is for inference: the average alone, a quarter of the size.
void Trainer::Save(const std::string& name, bool with_optimizer) {
  if (!team_.main()) return;
  SaveCheckpoint(CheckpointPath(name), info_, learner_->network(), *average_,
                 with_optimizer ? optimizer_.get() : nullptr);
}

void Trainer::Step(const std::vector<TrainingItem>& items, std::int64_t iteration) {
  const auto& train = options_.train;
  const double rate = Rate(iteration);
  for (auto& group : optimizer_->param_groups()) group.options().set_lr(rate);
  optimizer_->zero_grad();
  const auto shares = team_.Shares(learner_->LossWeights(items));
  const auto loss = learner_->Compute(items, iteration, shares);
  std::vector<double> joint = {loss.total.item<double>()};
  for (std::size_t i = 0; i < shares.size(); ++i) joint.push_back(shares[i] * loss.parts[i]);
  joint = team_.Sum(std::move(joint));
  if (!std::isfinite(joint.front()))
    throw Error("the loss is not finite at iteration " + std::to_string(iteration) + "; the last good checkpoint is " +
                CheckpointPath("last.safetensors") + " (iteration " + std::to_string(info_.iteration) +
                "). A smaller train.learning_rate may help");
  constexpr double kWeight = 0.05;  // Of a step in the mean that is shown.
  shown_loss_ = std::isnan(shown_loss_) ? joint.front() : shown_loss_ + kWeight * (joint.front() - shown_loss_);
  loss.total.backward();
  team_.SumGradients(learner_->network().parameters());
  if (train.clip_norm > 0) torch::nn::utils::clip_grad_norm_(learner_->network().parameters(), train.clip_norm);
  FusedAdamStep(*optimizer_);
  average_->Update(learner_->network());
  for (std::size_t i = 0; i < info_.losses.sums.size(); ++i) info_.losses.sums[i] += joint[i + 1];
  ++info_.losses.steps;
}

std::optional<std::vector<double>> Trainer::Validate(const std::atomic<bool>& stop) {
  average_->CopyTo(learner_->averaged());
  const int threads = torch::get_num_threads();
  const auto start = std::chrono::steady_clock::now();
  const std::int64_t size = validation_->size();
  const auto accuracies = validation_->Run(*learner_->AveragedEstimator(), [&](std::int64_t done) {
    const double seconds = SecondsSince(start);
    validation_seconds_ = seconds / done * size;
    if (progress_)
      progress_->Advance(0, "validation " + std::to_string(done) + "/" + std::to_string(size),
                         SecondsLeft() + validation_seconds_ - seconds);
    return !stop.load();
  });
  torch::set_num_threads(threads);  // Inference on a CPU takes one for each call.
  return accuracies;
}

TrainOutcome Trainer::Run(const std::atomic<bool>& stop) {
  try {
    return RunSteps(stop);
  } catch (const GroupLost& lost) {
    EndPage();
    // A step changes the network only after the last exchange, so what is here is that of a whole number of steps.
    Save("last.safetensors", true);
    throw Error(std::string(lost.what()) + "; training stopped at iteration " + std::to_string(info_.iteration) +
                ", continue from " + CheckpointPath("last.safetensors") + " with --resume");
  } catch (...) {
    EndPage();
    throw;
  }
}

// A page that goes on to load itself would look like a training that goes on. What went wrong is said elsewhere.
void Trainer::EndPage() noexcept {
  try {
    if (log_) log_->Tell(false);
  } catch (const std::exception&) {
  }
}

// NaN where no validation is due.
std::optional<std::vector<double>> Trainer::ValidateWhenDue(std::int64_t done, const std::atomic<bool>& stop) {
  if (!ValidationDue(done)) return std::vector<double>(validation_->names().size(), kNotMeasured);
  const auto accuracies = Validate(stop);
  if (!accuracies) return std::nullopt;
  const double mean = std::accumulate(accuracies->begin(), accuracies->end(), 0.0) / accuracies->size();
  last_validation_ = mean;
  // Where validation is saturated, the longer trained.
  if (mean >= info_.best_validation) {
    info_.best_validation = mean;
    Save("best.safetensors", false);
  }
  LogInfo("iteration " + std::to_string(done) + ": validation " + ValidationMeasure(validation_->names().front()) +
          " " + Format("%.4f", mean) + " (best " + Format("%.4f", info_.best_validation) + ")");
  return accuracies;
}

void Trainer::AppendRow(std::int64_t iteration, double data_wait_seconds, const std::vector<double>& accuracies) {
  const double seconds = SecondsSince(window_start_);
  std::vector<double> row;
  for (double& sum : info_.losses.sums) row.push_back(std::exchange(sum, 0.0) / info_.losses.steps);
  row.push_back(Rate(iteration));
  row.push_back(seconds > 0 ? (data_wait_seconds - waited_) / seconds : 0.0);
  row.insert(row.end(), accuracies.begin(), accuracies.end());
  log_->Append(iteration + 1, row);
  info_.losses.steps = 0;
  window_start_ = std::chrono::steady_clock::now();
  waited_ = data_wait_seconds;
}

void Trainer::DrawCurves(bool running) {
  log_->Tell(running);
  drawn_ = std::chrono::steady_clock::now();
}

std::string Trainer::ProgressNote() const {
  std::string text = "loss " + Format("%.4g", shown_loss_);
  if (info_.best_validation < 0.0) return text;
  text += ", " + ValidationMeasure(validation_->names().front());
  if (!std::isnan(last_validation_)) text += " " + Format("%.4f", last_validation_);
  return text + " (best " + Format("%.4f", info_.best_validation) + ")";
}

double Trainer::SecondsLeft() const {
  const auto& train = options_.train;
  const std::int64_t steps = train.iterations - info_.iteration;
  const std::int64_t validations =
      (train.iterations + train.validate_every - 1) / train.validate_every - info_.iteration / train.validate_every;
  const bool ends = info_.iteration == train.iterations;
  return (steps_ > 0 ? step_seconds_ / steps_ * steps : 0.0) + (ends ? 0.0 : validation_seconds_ * validations);
}

bool Trainer::Report(std::int64_t iteration, double data_wait_seconds, const std::atomic<bool>& stop) {
  const auto& train = options_.train;
  const std::int64_t done = iteration + 1;
  const bool last = done == train.iterations;
  const auto due = [&](std::int64_t every) { return done % every == 0 || last; };
  const auto accuracies = ValidateWhenDue(done, stop);
  if (!accuracies) return false;
  const bool logs = due(train.log_every) || due(train.validate_every);
  if (logs) AppendRow(iteration, data_wait_seconds, *accuracies);
  if (due(train.checkpoint_every)) Save("last.safetensors", true);
  // The last are those of a finished run, also of one that was killed before it had drawn them.
  const bool old = std::chrono::steady_clock::now() - drawn_ > kCurveInterval;
  if ((due(train.validate_every) || (logs && old)) && !last) DrawCurves(true);
  return true;
}

TrainOutcome Trainer::Stop() {
  Save("last.safetensors", true);
  if (team_.main()) DrawCurves(false);
  LogWarning("stopped at iteration " + std::to_string(info_.iteration) + "; continue with --resume --output " +
             folder_.path());
  return TrainOutcome::kStopped;
}

TrainOutcome Trainer::RunSteps(const std::atomic<bool>& stop) {
  const auto& train = options_.train;
  LogInfo("task " + ToString(options_.task) + ", " + std::to_string(CountParameters(learner_->network())) +
          " parameters, device " + device_.str() + ", " + MachineText());
  const TrainingSource source(parts_, learner_->features(), options_.learner->labels(), train.two_view, train.seed);
  Prefetcher<TrainingItem> items([&](std::uint64_t k) { return source.Make(team_.ItemIndex(k)); }, train.workers,
                                 4 * team_.batch(), static_cast<std::uint64_t>(info_.iteration) * team_.batch());
  if (info_.iteration == train.iterations)
    LogInfo("nothing is left to do: all " + std::to_string(train.iterations) + " iterations are done");
  if (team_.main() && info_.iteration < train.iterations) {
    Validate(std::atomic<bool>(true));  // Of its first problems, so that the first forecast knows of it.
    progress_.emplace("training", train.iterations - info_.iteration);
  }
  window_start_ = std::chrono::steady_clock::now();
  waited_ = items.wait_seconds();
  // What was stopped in a validation has steps of which no row of metrics tells.
  if (team_.main() && info_.iteration > 0 && ValidationDue(info_.iteration) && info_.losses.steps > 0 &&
      !Report(info_.iteration - 1, waited_, stop) && info_.iteration == train.iterations)
    return Stop();
  for (std::int64_t iteration = info_.iteration; iteration < train.iterations; ++iteration) {
    if (team_.Any(stop.load())) return Stop();
    const auto start = std::chrono::steady_clock::now();
    std::vector<TrainingItem> batch;
    for (int b = 0; b < team_.batch(); ++b) batch.push_back(items.Next());
    Step(batch, iteration);
    info_.iteration = iteration + 1;
    step_seconds_ += SecondsSince(start);
    ++steps_;
    if (!team_.main()) continue;
    const bool reported = Report(iteration, items.wait_seconds(), stop);
    progress_->Advance(1, reported ? ProgressNote() : "", SecondsLeft());
    if (!reported && info_.iteration == train.iterations) return Stop();
  }
  if (team_.main()) DrawCurves(false);
  if (progress_) progress_->Finish();
  return TrainOutcome::kFinished;
}

}  // namespace

TrainOutcome Train(const TrainRequest& request, const std::atomic<bool>& stop) { return Trainer(request).Run(stop); }

}  // namespace diffsac
