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
  std::shared_ptr<DiffsacNetwork> Make(Task task, const Rng& rng) const {
    return std::make_shared<DiffsacNetwork>(task, network, rng);
  }
  const PointFeaturesOptions& features() const override { return network.features; }
  ItemLabels labels() const override { return {label_options, noise_copies}; }
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

class DiffsacLearner : public NetworkLearner<DiffsacEstimator, DiffsacTraining> {
 public:
  using NetworkLearner::NetworkLearner;
  std::vector<std::string> loss_names() const override { return {"loss_diffusion", "loss_inlier"}; }
  std::vector<double> LossWeights(const std::vector<TrainingItem>& items) const override {
    return DiffusionLossWeights(items, own_.noise_copies, own_.positive_weight);
  }
  Loss Compute(const std::vector<TrainingItem>& items, std::int64_t iteration,
               const std::vector<double>& shares) override;

 private:
  struct Losses {
    torch::Tensor diffusion, inlier;
  };
  /// The items' labels, with noise and times drawn for each.
  StepTensors Drawn(const std::vector<TrainingItem>& items) const;
  /// c_t and t.
  std::pair<torch::Tensor, torch::Tensor> Noised(const StepTensors& step) const;
  Losses Forward(const StepTensors& step);
};

StepTensors DiffsacLearner::Drawn(const std::vector<TrainingItem>& items) const {
  StepTensors step;
  step.points = CollatePoints(items);
  const std::int64_t batch = step.points.size(), copies = own_.noise_copies, points = step.points.max_points();
  step.inliers = torch::zeros({batch, points});
  step.labels = torch::full({batch, copies, points}, -1.0f);
  step.noise = torch::zeros({batch, copies, points});
  step.times = torch::empty({batch, copies}, torch::kLong);
  for (std::int64_t b = 0; b < batch; ++b) {
    const TrainingItem& item = items[b];
    std::copy(item.inliers.begin(), item.inliers.end(), step.inliers.data_ptr<float>() + b * points);
    const Rng rng = RandomOf(options_.train.seed, item.index);
    Rng times = rng.Fork("time"), noises = rng.Fork("noise");
    for (std::int64_t k = 0; k < copies; ++k) {
      const std::int64_t row = b * copies + k;
      step.times.data_ptr<std::int64_t>()[row] = static_cast<std::int64_t>(times.Below(own_.network.schedule.steps));
      float* noise = step.noise.data_ptr<float>() + row * points;
      std::generate_n(noise, step.points.lengths[b], [&] { return static_cast<float>(noises.Normal()); });
    }
    for (std::size_t k = 0; k < item.labels.size(); ++k)
      for (const int i : item.labels[k])
        step.labels.data_ptr<float>()[(b * copies + static_cast<std::int64_t>(k)) * points + i] = 1.0f;
  }
  step.points = step.points.To(device_);
  for (auto* tensor : {&step.inliers, &step.labels, &step.noise, &step.times}) *tensor = tensor->to(device_);
  return step;
}

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
  const auto losses = Forward(Drawn(items));
  auto total = shares[0] * losses.diffusion;
  if (losses.inlier.defined()) total = total + own_.inlier_weight * shares[1] * losses.inlier;
  return {total, {losses.diffusion.item<double>(), losses.inlier.defined() ? losses.inlier.item<double>() : 0.0}};
}

const RegisteredLearner<DiffsacTraining, DiffsacLearner> kDiffsac(
    "diffsac", "Diffusion of confidences that guide the choice of minimal sets (the paper).");

}  // namespace
}  // namespace diffsac
