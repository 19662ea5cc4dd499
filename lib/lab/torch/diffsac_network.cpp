#include "lab/torch/diffsac_network.h"

#include <torch/torch.h>

#include <limits>
#include <utility>

#include "diffsac/estimate/diffsac_model.h"
#include "lab/torch/losses.h"
#include "lab/torch/tensor_sampler.h"

namespace diffsac {

DiffsacNetwork::DiffsacNetwork(Task task_value, const NetworkOptions& network_options, Rng rng)
    : LearnedNetwork(task_value, network_options) {
  module = std::make_shared<Denoiser>(network_options.denoiser,
                                      FeatureColumns(features.width(), features.first_residual()), rng);
}

torch::Tensor DiffsacNetwork::Confidence(const torch::Tensor& output) const {
  return options.loss == DiffusionLossKind::kBce ? LogitsToConfidence(output) : output;
}

std::shared_ptr<DiffsacNetwork> LoadNetwork(const TrainedConfig& trained, const torch::Device& device) {
  const NetworkOptions options = ReadNetworkOptions(GroupOf(trained, "network"));
  auto network = std::make_shared<DiffsacNetwork>(trained.task, options, Rng(trained.seed));
  network->Load(trained, device);
  return network;
}

namespace {

// Standard normal noise [B, κ, N]; a problem's noise depends on its own seed, never on its batch mates or padding.
torch::Tensor DrawNoise(std::span<const std::uint64_t> seeds, const std::vector<std::int64_t>& lengths,
                        std::int64_t copies, std::int64_t points, const char* name, int step) {
  auto noise = torch::zeros({static_cast<std::int64_t>(seeds.size()), copies, points});
  float* out = noise.data_ptr<float>();
  for (std::size_t b = 0; b < seeds.size(); ++b) {
    Rng rng = Rng(seeds[b]).Fork(name, static_cast<std::uint64_t>(step));
    for (std::int64_t k = 0; k < copies; ++k) {
      float* row = out + (static_cast<std::int64_t>(b) * copies + k) * points;
      for (std::int64_t i = 0; i < lengths[b]; ++i) row[i] = static_cast<float>(rng.Normal());
    }
  }
  return noise;
}

// Keeps the `count` points of highest inlier logit. Returns their indices [B, count].
torch::Tensor KeepLikelyPoints(Context& context, std::int64_t count) {
  auto logits = context.inlier_logits;
  if (context.mask.defined()) logits = logits.masked_fill(context.mask.logical_not(), -1e9);
  const auto kept = std::get<1>(logits.topk(count, -1));
  for (torch::Tensor* rows : {&context.points, &context.agreements})
    if (rows->defined()) *rows = rows->gather(1, kept.unsqueeze(-1).expand({-1, -1, rows->size(2)}));
  if (context.mask.defined()) context.mask = context.mask.gather(1, kept);
  return kept;
}

/// ĉ_0 of the decoded points [B, κ, M], and the prediction of each network call.
struct DecodedSteps {
  torch::Tensor final;
  std::vector<torch::Tensor> steps;
  std::vector<double> times;
};

// One batch on its way back from noise.
class Denoising {
 public:
  Denoising(const DiffsacNetwork& network, const DenoisingOptions& options, const PointBatch& batch,
            std::span<const std::uint64_t> seeds, Context context)
      : network_(network), options_(options), batch_(batch), seeds_(seeds), context_(std::move(context)) {
    const std::int64_t limit = options.max_decoded_points;
    if (limit > 0 && limit < batch.max_points()) kept_ = KeepLikelyPoints(context_, limit);
  }

  DecodedSteps Run(const ReverseSampler& sampler) {
    DecodedSteps result;
    const auto last = network_.options.direct ? Direct(&result) : Reverse(sampler, &result);
    result.final = OfAllPoints(last);
    for (auto& step : result.steps) step = OfAllPoints(step);
    return result;
  }

 private:
  // ĉ_0 without diffusion: one call on nothing.
  torch::Tensor Direct(DecodedSteps* result) {
    const double last = network_.options.schedule.steps - 1;
    const auto nothing = torch::zeros({batch_.size(), 1, context_.points.size(1)}, context_.points.options());
    const auto prediction = Call(nothing, last).expand({-1, options_.num_diffusion_samples, -1}).contiguous();
    Keep(last, prediction, result);
    return prediction;
  }

  torch::Tensor Reverse(const ReverseSampler& sampler, DecodedSteps* result) {
    return sampler.Sample([&](const torch::Tensor& c_t, double t) { return Call(c_t, t); }, Noise("c_T", 0),
                          [&](int step) { return Noise("step_noise", step); },
                          [&](int, double t, const torch::Tensor&, const torch::Tensor& c0) { Keep(t, c0, result); });
  }

  torch::Tensor Call(const torch::Tensor& c_t, double t) {
    const auto time = torch::full({1, 1}, t, c_t.options());
    return network_.Confidence(network_.module->Denoise(context_, c_t, time));
  }

  void Keep(double t, const torch::Tensor& prediction, DecodedSteps* result) const {
    if (!options_.keep_steps) return;
    result->steps.push_back(prediction.to(torch::kCPU));
    result->times.push_back(t);
  }

  torch::Tensor Places(const torch::Tensor& kept) const {
    return kept.unsqueeze(1).expand({-1, options_.num_diffusion_samples, -1});
  }

  torch::Tensor Noise(const char* name, int step) const {
    const auto full =
        DrawNoise(seeds_, batch_.lengths, options_.num_diffusion_samples, batch_.max_points(), name, step);
    return kept_.defined() ? full.to(network_.device).gather(2, Places(kept_)) : full.to(network_.device);
  }

  torch::Tensor OfAllPoints(const torch::Tensor& decoded) const {
    const auto values = decoded.to(torch::kCPU).to(torch::kFloat);
    if (!kept_.defined()) return values.contiguous();
    const auto lowest = -std::numeric_limits<float>::infinity();
    return torch::full({batch_.size(), options_.num_diffusion_samples, batch_.max_points()}, lowest)
        .scatter(2, Places(kept_.to(torch::kCPU)), values)
        .contiguous();
  }

  const DiffsacNetwork& network_;
  const DenoisingOptions& options_;
  const PointBatch& batch_;
  std::span<const std::uint64_t> seeds_;
  Context context_;
  torch::Tensor kept_;  // [B, M] places of the decoded points; undefined: all are
};

// The b-th problem's rows [κ, N] of a tensor, without padding.
std::vector<float> RowsOf(const torch::Tensor& all, std::int64_t b, std::int64_t length) {
  const std::int64_t copies = all.size(1), points = all.size(2);
  const float* row = all.data_ptr<float>() + b * copies * points;
  std::vector<float> rows;
  for (std::int64_t k = 0; k < copies; ++k, row += points) rows.insert(rows.end(), row, row + length);
  return rows;
}

}  // namespace

std::vector<Denoised> DiffsacNetwork::Run(const DenoisingOptions& denoising, std::span<const FeatureSet* const> sets,
                                          std::span<const std::uint64_t> seeds, int) const {
  const c10::InferenceMode inference;
  BeginCall(*this);
  const auto batch = MakePointBatch(sets).To(device);
  auto context = module->Encode(batch);
  std::vector<Denoised> results(sets.size());
  if (context.inlier_logits.defined()) {
    const auto weights = context.inlier_logits.sigmoid().unsqueeze(1).to(torch::kCPU, torch::kFloat).contiguous();
    for (std::size_t b = 0; b < results.size(); ++b)
      results[b].weights = RowsOf(weights, static_cast<std::int64_t>(b), batch.lengths[b]);
  }
  if (denoising.num_diffusion_samples == 0) return results;
  const auto sampler = MakeReverseSampler(denoising.sampler, schedule);
  const auto decoded = Denoising(*this, denoising, batch, seeds, std::move(context)).Run(*sampler);
  for (std::size_t b = 0; b < results.size(); ++b) {
    const auto problem = static_cast<std::int64_t>(b);
    results[b].confidences = RowsOf(decoded.final, problem, batch.lengths[b]);
    for (const auto& step : decoded.steps) results[b].steps.push_back(RowsOf(step, problem, batch.lengths[b]));
    results[b].times = decoded.times;
  }
  return results;
}

const Registered<DiffsacEngine> kLibTorch("libtorch",
                                          {[](const std::string& device) { return DeviceFromString(device).is_cpu(); },
                                           [](const TrainedConfig& trained,
                                              const std::string& device) -> std::shared_ptr<const DiffsacModel> {
                                             return LoadNetwork(trained, DeviceFromString(device));
                                           }});

}  // namespace diffsac
