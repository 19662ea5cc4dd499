#include "diffsac/estimate/diffsac_model.h"

#include <limits>
#include <mutex>
#include <utility>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/point_prior.h"
#include "diffsac/guidance/diffusion/confidence_rows.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
#include "diffsac/guidance/engine/cpu_denoiser.h"

namespace diffsac {
namespace {

using Workspace = CpuDenoiser::Workspace;

/// Workspaces that calls leave for those that follow.
class Workspaces {
 public:
  std::unique_ptr<Workspace> Take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<Workspace>();
    auto work = std::move(free_.back());
    free_.pop_back();
    return work;
  }
  /// Large ones are given up: one large problem should not hold memory for ever.
  void GiveBack(std::unique_ptr<Workspace> work) {
    constexpr std::size_t kMostFloats = std::size_t{1} << 20;
    if (work->context.capacity() > kMostFloats) return;
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(work));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> free_;
};

class FusedDiffsac : public DiffsacModel {
 public:
  FusedDiffsac(const TrainedConfig& trained, const NetworkOptions& network_options)
      : DiffsacModel(trained.task, network_options) {
    SafetensorsFile file = OpenCheckpoint(trained.checkpoint);
    const FeatureColumns columns(features.width(), features.first_residual());
    denoiser_ = std::make_unique<CpuDenoiser>(options, columns, &file);
    facts = trained.facts;
    facts.parameters = denoiser_->parameters();
    batches = false;
  }

  std::vector<Denoised> Run(const DenoisingOptions& denoising, std::span<const FeatureSet* const> sets,
                            std::span<const std::uint64_t> seeds, int threads) const override;

  const CpuDenoiser& denoiser() const { return *denoiser_; }

 private:
  /// sampler: null for no copies.
  Denoised RunOne(const DenoisingOptions& denoising, const ConfidenceSampler* sampler, const FeatureSet& set,
                  std::uint64_t seed) const;

  std::unique_ptr<CpuDenoiser> denoiser_;
  mutable Workspaces workspaces_;
};

/// One problem on its way back from noise. Its noise is that of all its points, of which only some may be decoded.
class Denoising {
 public:
  Denoising(const FusedDiffsac& network, const DenoisingOptions& options, std::uint64_t seed, Workspace* work)
      : network_(network), options_(options), rng_(seed), work_(work), points_(work->points) {
    const int limit = options.max_decoded_points;
    if (limit <= 0 || limit >= points_) return;
    kept_ = LikeliestPoints(Eigen::Map<const Eigen::VectorXf>(work->logits.data(), points_), limit);
    network.denoiser().Keep(kept_, work);
  }

  void Run(const ConfidenceSampler& sampler, Denoised* result) {
    const auto call = [&](const ConfidenceRows& c_t, double t) { return Call(c_t, t); };
    const auto keep = [&](int, double t, const ConfidenceRows&, const ConfidenceRows& c0) { Keep(t, c0, result); };
    if (network_.options.direct) {
      result->confidences = OfAllPoints(Direct(result));
      return;
    }
    const ConfidenceRows last = sampler.Sample(
        call, Noise("c_T", 0), [&](int step) { return Noise("step_noise", step); }, keep);
    result->confidences = OfAllPoints(last);
  }

 private:
  /// ĉ_0 without diffusion: one call on nothing.
  ConfidenceRows Direct(Denoised* result) {
    const double last = network_.options.schedule.steps - 1;
    const ConfidenceRows one = Call({Eigen::ArrayXf::Zero(work_->points)}, last, 1);
    const ConfidenceRows all{one.values.replicate(options_.num_diffusion_samples, 1)};
    Keep(last, all, result);
    return all;
  }

  ConfidenceRows Call(const ConfidenceRows& c_t, double t) { return Call(c_t, t, options_.num_diffusion_samples); }
  ConfidenceRows Call(const ConfidenceRows& c_t, double t, int copies) {
    ConfidenceRows out{Eigen::ArrayXf(c_t.values.size())};
    network_.denoiser().Denoise(c_t.values.data(), copies, t, work_, out.values.data());
    if (network_.options.loss == DiffusionLossKind::kBce)
      network_.denoiser().kernels().confidence(out.values.data(), static_cast<std::size_t>(out.values.size()));
    return out;
  }

  void Keep(double t, const ConfidenceRows& prediction, Denoised* result) const {
    if (!options_.keep_steps) return;
    result->steps.push_back(OfAllPoints(prediction));
    result->times.push_back(t);
  }

  ConfidenceRows Noise(const char* name, int step) const {
    const Rng rng = rng_.Fork(name, static_cast<std::uint64_t>(step));
    ConfidenceRows noise{Eigen::ArrayXf(static_cast<Eigen::Index>(options_.num_diffusion_samples) * work_->points)};
    float* out = noise.values.data();
    for (int k = 0; k < options_.num_diffusion_samples; ++k)
      for (int i = 0; i < work_->points; ++i)
        *out++ =
            static_cast<float>(rng.NormalAt(static_cast<std::uint64_t>(k) * points_ + (kept_.empty() ? i : kept_[i])));
    return noise;
  }

  std::vector<float> OfAllPoints(const ConfidenceRows& decoded) const {
    const float* values = decoded.values.data();
    if (kept_.empty()) return {values, values + decoded.values.size()};
    std::vector<float> all(static_cast<std::size_t>(options_.num_diffusion_samples) * points_,
                           -std::numeric_limits<float>::infinity());
    for (int k = 0; k < options_.num_diffusion_samples; ++k)
      for (const int i : kept_) all[static_cast<std::size_t>(k) * points_ + i] = *values++;
    return all;
  }

  const FusedDiffsac& network_;
  const DenoisingOptions& options_;
  Rng rng_;
  Workspace* work_;
  int points_;
  std::vector<int> kept_;  ///< Places of the decoded points; empty: all are.
};

std::vector<Denoised> FusedDiffsac::Run(const DenoisingOptions& denoising, std::span<const FeatureSet* const> sets,
                                        std::span<const std::uint64_t> seeds, int threads) const {
  std::unique_ptr<ConfidenceSampler> sampler;
  if (denoising.num_diffusion_samples > 0) sampler = MakeConfidenceSampler(denoising.sampler, schedule);
  std::vector<Denoised> results(sets.size());
  ParallelFor(static_cast<std::int64_t>(sets.size()), threads,
              [&](std::int64_t b) { results[b] = RunOne(denoising, sampler.get(), *sets[b], seeds[b]); });
  return results;
}

Denoised FusedDiffsac::RunOne(const DenoisingOptions& denoising, const ConfidenceSampler* sampler,
                              const FeatureSet& set, std::uint64_t seed) const {
  auto work = workspaces_.Take();
  denoiser_->Encode(set.values.data(), static_cast<int>(set.values.rows()), work.get());
  Denoised result;
  result.weights = work->logits;
  denoiser_->kernels().sigmoid(result.weights.data(), result.weights.size());
  if (sampler != nullptr) Denoising(*this, denoising, seed, work.get()).Run(*sampler, &result);
  workspaces_.GiveBack(std::move(work));
  return result;
}

}  // namespace

std::shared_ptr<const DiffsacModel> LoadFusedDiffsac(const TrainedConfig& trained, const NetworkOptions& options) {
  return std::make_shared<FusedDiffsac>(trained, options);
}

}  // namespace diffsac
