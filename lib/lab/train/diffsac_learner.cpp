#include <ATen/autocast_mode.h>
#include <torch/torch.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "diffsac/estimate/diffsac_estimator.h"
#include "lab/options/options.h"
#include "lab/torch/diffsac_network.h"
#include "lab/torch/forward_process.h"
#include "lab/torch/losses.h"
#include "lab/train/batch_tensors.h"
#include "lab/train/distributed.h"
#include "lab/train/network_learner.h"

namespace diffsac {

enum class TrainingPrecision { kAuto, kFloat32, kBfloat16 };
template <>
inline constexpr auto kEnumNames<TrainingPrecision> =
    NamesOf<TrainingPrecision>({{TrainingPrecision::kAuto, "auto"},
                                {TrainingPrecision::kFloat32, "float32"},
                                {TrainingPrecision::kBfloat16, "bfloat16"}});

namespace {

/// What `method: diffsac` has for itself in a training configuration.
struct DiffsacTraining : LearnerOptions {
  NetworkOptions network;
  LabelOptions label_options;
  DiffsacOptions inference;
  int noise_copies = 4;  ///< draws of (label, t, noise) for each problem; the encoder runs once for them
  double inlier_weight = 1.0;
  double positive_weight = 1.0;
  TrainingPrecision precision = TrainingPrecision::kAuto;

  explicit DiffsacTraining(Task) {}
  const PointFeaturesOptions& features() const override { return network.features; }
  LabelOptions labels() const override { return label_options; }
  void Bind(OptionsBinder& b) override;
  void BindTrain(OptionsBinder& b) override;
};

void DiffsacTraining::Bind(OptionsBinder& b) {
  b.Field("network", network).Help("what must be the same in training and in inference");
  b.Field("labels", label_options).Help("the minimal sets that are learned");
  b.Field("inference", inference).Help("how the network is used in validation and, unless they say otherwise, in rows");
  label_options.model = inference.model = model;
}

void DiffsacTraining::BindTrain(OptionsBinder& b) {
  b.Field("noise_copies", noise_copies, Within(1, 10000))
      .Help("draws of (label, t, noise) for each problem; the encoder runs once for them");
  b.Field("inlier_weight", inlier_weight, AtLeast(0))
      .OnlyIf(network.denoiser.inlier_head, "network.denoiser.inlier_head")
      .Help("weight of the inlier head's cross-entropy beside the diffusion loss");
  b.Field("positive_weight", positive_weight, Positive())
      .Help("weight of the minimal set's points in the diffusion loss");
  b.Field("precision", precision).Help("`auto`: bfloat16 on GPUs and, but for pooled networks, CPUs that have it");
}

struct StepTensors {
  PointBatch points;
  torch::Tensor inliers, labels, noise, times;  // [B, N], [B, K, N], [B, K, N], [B, K]
};

// [items, rows, N] of the items' values, rows × length each; behind an item's length is `padding`.
torch::Tensor Padded(const std::vector<TrainingItem>& items, std::vector<float> TrainingItem::*values,
                     std::int64_t rows, const PointBatch& points, float padding) {
  const std::int64_t longest = points.max_points();
  auto tensor = torch::empty({points.size(), rows, longest});
  float* out = tensor.data_ptr<float>();
  for (std::int64_t b = 0; b < points.size(); ++b) {
    const float* in = (items[b].*values).data();
    for (std::int64_t k = 0; k < rows; ++k, out += longest, in += points.lengths[b])
      std::fill(std::copy_n(in, points.lengths[b], out), out + longest, padding);
  }
  return tensor;
}

StepTensors Collate(const std::vector<TrainingItem>& items, int copies, const torch::Device& device) {
  StepTensors step;
  step.points = CollatePoints(items);
  step.inliers = Padded(items, &TrainingItem::inliers, 1, step.points, 0.0f).squeeze(1);
  step.labels = Padded(items, &TrainingItem::labels, copies, step.points, -1.0f);
  step.noise = Padded(items, &TrainingItem::noise, copies, step.points, 0.0f);
  step.times = torch::empty({step.points.size(), copies}, torch::kLong);
  for (std::size_t b = 0; b < items.size(); ++b)
    std::copy_n(items[b].times.data(), copies,
                step.times.data_ptr<std::int64_t>() + static_cast<std::int64_t>(b) * copies);
  step.points = step.points.To(device);
  for (auto* tensor : {&step.inliers, &step.labels, &step.noise, &step.times}) *tensor = tensor->to(device);
  return step;
}

// 16 bits are for other devices; on a CPU converting costs a pooled network more than its narrow products gain
// (benchmarks/README.md).
bool UseBfloat16(const DiffsacTraining& own, const torch::Device& device) {
  if (own.precision != TrainingPrecision::kAuto) return own.precision == TrainingPrecision::kBfloat16;
  if (!device.is_cpu()) return true;
  return own.network.denoiser.kind != DenoiserKind::kPooled && __builtin_cpu_supports("avx512bf16");
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

class DiffsacLearner : public NetworkLearner<DiffsacNetwork, DiffsacEstimator, DiffsacTraining> {
 public:
  DiffsacLearner(const TrainConfig& options, const DiffsacTraining& own, const torch::Device& device, int threads)
      : NetworkLearner(options, own, device, threads, [&](Task task, const Rng& rng) {
          return std::make_shared<DiffsacNetwork>(task, own.network, rng);
        }) {}
  int copies() const override { return own_.noise_copies; }
  int schedule_steps() const override { return own_.network.schedule.steps; }
  std::vector<std::string> loss_names() const override { return {"loss_diffusion", "loss_inlier"}; }
  std::vector<double> LossWeights(const std::vector<TrainingItem>& items) const override {
    return diffsac::LossWeights(items, own_.positive_weight);
  }
  Loss Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
               const std::vector<double>& shares) override;

 private:
  struct Losses {
    torch::Tensor diffusion, inlier;
  };
  /// c_t and t.
  std::pair<torch::Tensor, torch::Tensor> Noised(const StepTensors& step) const;
  Losses Forward(const StepTensors& step);
};

std::pair<torch::Tensor, torch::Tensor> DiffsacLearner::Noised(const StepTensors& step) const {
  const auto t = step.times.to(torch::kFloat);
  if (own_.network.direct)
    return {torch::zeros_like(step.labels), torch::full_like(t, own_.network.schedule.steps - 1)};
  const auto c_t =
      AddNoise(network_->schedule, step.labels.flatten(0, 1), step.noise.flatten(0, 1), step.times.flatten());
  return {c_t.view_as(step.labels), t};
}

DiffsacLearner::Losses DiffsacLearner::Forward(const StepTensors& step) {
  const Autocast autocast(UseBfloat16(own_, device_), device_);
  auto& denoiser = *network_->module;
  const auto context = denoiser.Encode(step.points);
  const auto [c_t, t] = Noised(step);
  const auto output = denoiser.Denoise(context, c_t, t).to(torch::kFloat);
  const auto mask = step.points.mask.defined() ? step.points.mask.unsqueeze(1).expand_as(output) : torch::Tensor();
  Losses losses;
  losses.diffusion = DiffusionLoss(own_.network.loss, output, step.labels, mask, own_.positive_weight);
  if (context.inlier_logits.defined()) {
    losses.inlier = DiffusionLoss(DiffusionLossKind::kBce, context.inlier_logits.to(torch::kFloat),
                                  step.inliers * 2 - 1, step.points.mask, 1.0);
  }
  return losses;
}

Learner::Loss DiffsacLearner::Compute(const std::vector<TrainingItem>& items, std::int64_t /*iteration*/,
                                      const std::vector<double>& shares) {
  const auto losses = Forward(Collate(items, own_.noise_copies, device_));
  auto total = shares[0] * losses.diffusion;
  if (losses.inlier.defined()) total = total + own_.inlier_weight * shares[1] * losses.inlier;
  return {total, {losses.diffusion.item<double>(), losses.inlier.defined() ? losses.inlier.item<double>() : 0.0}};
}

const RegisteredLearner<DiffsacTraining, DiffsacLearner> kDiffsac(
    "diffsac", "Diffusion of confidences that guide the choice of minimal sets (the paper).");

}  // namespace
}  // namespace diffsac
