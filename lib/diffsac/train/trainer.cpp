#include "diffsac/train/trainer.h"

#include <ATen/autocast_mode.h>
#include <torch/torch.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/progress.h"
#include "diffsac/core/run_directory.h"
#include "diffsac/data/prefetcher.h"
#include "diffsac/denoiser/checkpoint.h"
#include "diffsac/diffusion/losses.h"
#include "diffsac/train/distributed.h"
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

struct StepTensors {
  PointBatch points;
  torch::Tensor inliers, labels, noise, times;   // [B, N], [B, K, N], [B, K, N], [B, K]
};

StepTensors Collate(const std::vector<TrainingItem>& items, int copies, const torch::Device& device) {
  std::vector<const FeatureSet*> sets;
  for (const auto& item : items) sets.push_back(&item.features);
  StepTensors step;
  step.points = MakePointBatch(sets);
  const std::int64_t batch = static_cast<std::int64_t>(items.size()), points = step.points.max_points();
  step.inliers = torch::zeros({batch, points});
  step.labels = torch::full({batch, copies, points}, -1.0f);
  step.noise = torch::zeros({batch, copies, points});
  step.times = torch::empty({batch, copies}, torch::kLong);
  for (std::int64_t b = 0; b < batch; ++b) {
    const auto& item = items[b];
    const std::int64_t length = step.points.lengths[b];
    const auto view = [length](const std::vector<float>& values, std::int64_t first) {
      return torch::from_blob(const_cast<float*>(values.data()) + first, {length});
    };
    step.inliers[b].slice(0, 0, length).copy_(view(item.inliers, 0));
    for (std::int64_t k = 0; k < copies; ++k) {
      step.labels[b][k].slice(0, 0, length).copy_(view(item.labels, k * length));
      step.noise[b][k].slice(0, 0, length).copy_(view(item.noise, k * length));
      step.times.data_ptr<std::int64_t>()[b * copies + k] = item.times[k];
    }
  }
  step.points = step.points.To(device);
  for (auto* tensor : {&step.inliers, &step.labels, &step.noise, &step.times}) *tensor = tensor->to(device);
  return step;
}

bool UseBfloat16(const std::string& precision, const torch::Device& device) {
  if (precision != "auto") return precision == "bfloat16";
  return device.is_cuda() || __builtin_cpu_supports("avx512bf16");
}

// Switches autocast on for one scope.
class Autocast {
 public:
  Autocast(bool enabled, const torch::Device& device) : enabled_(enabled), type_(device.type()) {
    if (!enabled_) return;
    at::autocast::set_autocast_enabled(type_, true);
    at::autocast::set_autocast_dtype(type_, torch::kBFloat16);
  }
  ~Autocast() {
    if (!enabled_) return;
    at::autocast::clear_cache();
    at::autocast::set_autocast_enabled(type_, false);
  }

 private:
  bool enabled_;
  c10::DeviceType type_;
};

class Trainer {
 public:
  Trainer(const TrainRequest& request, const TrainConfig& options);
  TrainOutcome Run(const std::atomic<bool>& stop);

 private:
  TrainOutcome RunSteps(const std::atomic<bool>& stop);
  struct Losses {
    torch::Tensor diffusion, inlier;
  };
  Losses Forward(const StepTensors& step, std::int64_t iteration);
  void Step(const std::vector<TrainingItem>& items, std::int64_t iteration);
  std::vector<double> Validate();
  void Save(const std::string& name, bool with_optimizer);
  void Resume();
  std::string CheckpointPath(const std::string& name) const { return directory_.File("checkpoints/" + name); }

  TrainRequest request_;
  TrainConfig options_;
  TrainingTeam team_;
  Task task_;
  std::string resolved_;
  RunDirectory directory_;
  torch::Device device_;
  std::vector<TrainingPart> parts_;
  std::shared_ptr<DiffsacNetwork> network_;
  std::shared_ptr<DiffsacNetwork> averaged_;
  std::unique_ptr<ExponentialMovingAverage> average_;
  std::unique_ptr<torch::optim::Adam> optimizer_;
  std::unique_ptr<Validation> validation_;
  CheckpointInfo info_;
  double diffusion_loss_ = 0.0, inlier_loss_ = 0.0;
  std::int64_t losses_ = 0;
};

Trainer::Trainer(const TrainRequest& request, const TrainConfig& options)
    : request_(request),
      options_(options),
      team_(request.group, options.train.batch_size),
      task_(TaskFromString(options.task)),
      resolved_(ResolvedConfig(options, request.config)),
      directory_(team_.main() ? RunDirectory(request.output, "diffsac_train", resolved_, options.train.seed)
                              : RunDirectory(request.output)),
      device_(DeviceFromString(team_.Device(request.device))),
      parts_(MakeTrainingParts(request.config.Sub("data"), options.train.seed)) {
  const Task data_task = parts_.front().dataset->task();
  if (data_task != task_)
    throw Error(request.config.Where("data") + ": data of task '" + ToString(data_task) + "', but task is '" +
                options.task + "'");
  if (team_.main()) std::filesystem::create_directories(directory_.File("checkpoints"));
  torch::set_num_threads(request.threads > 0 ? request.threads : team_.threads());
  const Rng rng(options.train.seed);
  network_ = std::make_shared<DiffsacNetwork>(task_, options.network, rng);
  averaged_ = std::make_shared<DiffsacNetwork>(task_, options.network, rng);
  network_->MoveTo(device_);
  averaged_->MoveTo(device_);
  averaged_->denoiser->eval();
  if (!options.train.start_from.empty()) LoadAverage(options.train.start_from, *network_->denoiser);
  average_ = std::make_unique<ExponentialMovingAverage>(*network_->denoiser, options.train.ema_decay);
  optimizer_ = std::make_unique<torch::optim::Adam>(network_->denoiser->parameters(),
                                                    torch::optim::AdamOptions(options.train.learning_rate));
  if (team_.main()) validation_ = std::make_unique<Validation>(task_, request.config, options.validation, options.train.seed);
  info_ = {resolved_, GitRevision(), 0, options.train.seed, -1.0};
  if (request.resume) Resume();
  team_.CheckSame("configurations", resolved_);
  team_.CheckSame("iterations or weights", std::to_string(info_.iteration) + " " +
                                               WeightsText(network_->denoiser->parameters()));
}

void Trainer::Resume() {
  const auto path = CheckpointPath("last.pt");
  const auto info = LoadCheckpoint(path, *network_->denoiser, average_.get(), optimizer_.get());
  if (info.config != resolved_)
    throw Error(path + ": was trained with another configuration than " + request_.config.Where() +
                "; resume with the same one, or choose another --output");
  info_ = info;
  LogInfo("resuming " + path + " at iteration " + std::to_string(info_.iteration));
}

// best.pt is for inference: without the optimiser's state it is half the size.
void Trainer::Save(const std::string& name, bool with_optimizer) {
  if (!team_.main()) return;
  SaveCheckpoint(CheckpointPath(name), info_, *network_->denoiser, *average_,
                 with_optimizer ? optimizer_.get() : nullptr);
}

Trainer::Losses Trainer::Forward(const StepTensors& step, std::int64_t iteration) {
  const Autocast autocast(UseBfloat16(options_.train.precision, device_), device_);
  auto& denoiser = *network_->denoiser;
  const auto context = denoiser.Encode(step.points);
  const auto c_t = network_->schedule.AddNoise(step.labels.flatten(0, 1), step.noise.flatten(0, 1), step.times.flatten())
                       .view_as(step.labels);
  const auto t = step.times.to(torch::kFloat);
  torch::Tensor previous;
  if (options_.network.denoiser.self_conditioning) {
    Rng coin = Rng(options_.train.seed).Fork("self_conditioning", static_cast<std::uint64_t>(iteration));
    if (coin.Uniform() < options_.train.self_conditioning_probability) {
      const torch::NoGradGuard no_grad;
      previous = network_->Confidence(denoiser.Denoise(context, c_t, t).to(torch::kFloat)).detach();
    }
  }
  const auto output = denoiser.Denoise(context, c_t, t, previous).to(torch::kFloat);
  const auto mask = step.points.mask.defined() ? step.points.mask.unsqueeze(1).expand_as(output) : torch::Tensor();
  Losses losses;
  losses.diffusion =
      DiffusionLoss(options_.network.loss, output, step.labels, mask, options_.train.positive_weight);
  if (context.inlier_logits.defined()) {
    losses.inlier = DiffusionLoss("bce", context.inlier_logits.to(torch::kFloat), step.inliers * 2 - 1,
                                  step.points.mask, 1.0);
  }
  return losses;
}

void Trainer::Step(const std::vector<TrainingItem>& items, std::int64_t iteration) {
  const auto& train = options_.train;
  const auto step = Collate(items, train.noise_copies, device_);
  const double rate = LearningRate(iteration, train.warmup_iterations, train.iterations, train.learning_rate);
  for (auto& group : optimizer_->param_groups()) group.options().set_lr(rate);
  optimizer_->zero_grad();
  const auto losses = Forward(step, iteration);
  const auto shares = team_.Shares(LossWeights(items, train.positive_weight));
  auto total = shares[0] * losses.diffusion;
  if (losses.inlier.defined()) total = total + train.inlier_weight * shares[1] * losses.inlier;
  const auto joint = team_.Sum({shares[0] * losses.diffusion.item<double>(),
                                losses.inlier.defined() ? shares[1] * losses.inlier.item<double>() : 0.0});
  const double diffusion = joint[0], inlier = joint[1];
  if (!std::isfinite(diffusion + inlier))
    throw Error("the loss is not finite at iteration " + std::to_string(iteration) + "; the last good checkpoint is " +
                CheckpointPath("last.pt") + " (iteration " + std::to_string(info_.iteration) +
                "). A smaller train.learning_rate may help");
  total.backward();
  team_.SumGradients(network_->denoiser->parameters());
  if (train.clip_norm > 0) torch::nn::utils::clip_grad_norm_(network_->denoiser->parameters(), train.clip_norm);
  optimizer_->step();
  average_->Update(*network_->denoiser);
  diffusion_loss_ += diffusion;
  inlier_loss_ += inlier;
  ++losses_;
}

std::vector<double> Trainer::Validate() {
  average_->CopyTo(*averaged_->denoiser);
  const DiffsacMethod method(averaged_, options_.inference, request_.threads);
  return validation_->Run(method);
}

TrainOutcome Trainer::Run(const std::atomic<bool>& stop) {
  try {
    return RunSteps(stop);
  } catch (const GroupLost& lost) {
    // A step changes the network only after the last exchange, so what is here is that of a whole number of steps.
    Save("last.pt", true);
    throw Error(std::string(lost.what()) + "; training stopped at iteration " + std::to_string(info_.iteration) +
                ", continue from " + CheckpointPath("last.pt") + " with --resume");
  }
}

TrainOutcome Trainer::RunSteps(const std::atomic<bool>& stop) {
  const auto& train = options_.train;
  LogInfo("task " + options_.task + ", " + std::to_string(CountParameters(*network_->denoiser)) +
          " parameters, device " + device_.str() + ", " + MachineText());
  std::vector<std::string> columns = {"loss_diffusion", "loss_inlier", "learning_rate", "data_wait_share"};
  if (team_.main()) columns.insert(columns.end(), validation_->names().begin(), validation_->names().end());
  std::optional<MetricsLog> log;
  if (team_.main()) log.emplace(directory_.path(), columns, info_.iteration);

  const TrainingSource source(parts_, network_->features, options_.labels, train.two_view, train.noise_copies,
                              options_.network.schedule.steps, train.seed);
  Prefetcher<TrainingItem> items([&](std::uint64_t k) { return source.Make(team_.ItemIndex(k)); }, train.workers,
                                 4 * team_.batch(), static_cast<std::uint64_t>(info_.iteration) * team_.batch());
  std::optional<Progress> progress;
  if (team_.main()) progress.emplace("training", train.iterations - info_.iteration);
  auto window_start = std::chrono::steady_clock::now();
  double waited = items.wait_seconds();
  for (std::int64_t iteration = info_.iteration; iteration < train.iterations; ++iteration) {
    if (team_.Any(stop.load())) {
      Save("last.pt", true);
      LogWarning("stopped at iteration " + std::to_string(info_.iteration) + "; continue with --resume");
      return TrainOutcome::kStopped;
    }
    std::vector<TrainingItem> batch;
    for (int b = 0; b < team_.batch(); ++b) batch.push_back(items.Next());
    Step(batch, iteration);
    const std::int64_t done = info_.iteration = iteration + 1;
    if (!team_.main()) continue;
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
      std::vector<double> row = {diffusion_loss_ / losses_, inlier_loss_ / losses_,
                                 LearningRate(iteration, train.warmup_iterations, train.iterations, train.learning_rate),
                                 share};
      row.insert(row.end(), accuracies.begin(), accuracies.end());
      log->Append(done, row);
      diffusion_loss_ = inlier_loss_ = 0.0;
      losses_ = 0;
      window_start = std::chrono::steady_clock::now();
      waited = items.wait_seconds();
    }
    if (done % train.checkpoint_every == 0 || last) Save("last.pt", true);
    if (done % train.validate_every == 0 || last) log->Draw();
    progress->Advance();
  }
  if (progress) progress->Finish();
  return TrainOutcome::kFinished;
}

}  // namespace

TrainOutcome Train(const TrainRequest& request, const std::atomic<bool>& stop) {
  const auto options = ReadTrainConfig(request.config);
  return Trainer(request, options).Run(stop);
}

}  // namespace diffsac
