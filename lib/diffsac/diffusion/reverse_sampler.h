#pragma once

#include <torch/types.h>

#include <memory>
#include <string>
#include <utility>

#include "diffsac/core/options.h"
#include "diffsac/diffusion/noise_schedule.h"
#include "diffsac/diffusion/sampling.h"
#include "diffsac/diffusion/time_grid.h"

namespace diffsac {

/// How confidences are drawn. The paper describes three reverse processes that differ (its Algorithm 2, p_θ with √α_t,
/// and a re-noising update), so each reading that is a sampler has a name.
struct SamplerOptions {
  /// - "ddpm": the posterior q(c_{t−1} | c_t, ĉ_0) of Ho et al. 2020, also over strided steps.
  /// - "renoise": the paper's update in its inference section, c_{t−1} = √ᾱ_{t−1} ĉ_0 + √(1 − ᾱ_{t−1}) z, which is
  ///   multistep consistency sampling (Song et al., ICML 2023).
  /// - "ddim": Song et al., ICLR 2021.
  /// - "dpm_solver_pp": DPM-Solver++ (the paper's experiments use it).
  std::string kind = "dpm_solver_pp";
  /// Steps, at most the schedule's T. `ddpm` as published takes all T.
  int steps = 10;
  /// dpm_solver_pp: 1 or 2.
  int order = 2;
  /// dpm_solver_pp of order 2: "2M" (one network call a step) or "2S" (two).
  std::string variant = "2M";
  /// "linspace", "leading", "trailing" (of the index, as diffusers), "uniform_lambda" (of λ, at real-valued indices),
  /// "karras", "lu" (as diffusers: steps of σ^(1/7) and of λ with rounded indices).
  std::string timestep_spacing = "linspace";
  /// Where the last step ends: "zero" on clean data (the answer is the last ĉ_0),
  /// "sigma_min" at index 0.
  std::string final_sigma = "zero";
  /// dpm_solver_pp 2M with fewer than 15 steps: the last one is of order 1.
  bool lower_order_final = true;
  /// Timesteps with a smaller λ are left out, since the solver is unstable there with the cosine schedule; -1000 or
  /// less keeps all, and with it a zero-terminal-SNR schedule starts at exactly no signal.
  double lambda_min_clipped = -5.1;
  /// ddim: 0 deterministic, 1 as noisy as ddpm.
  double ddim_eta = 0.0;
  /// dpm_solver_pp: the stochastic variant (sde-dpmsolver++); not with 2S.
  bool sde = false;
  /// Clamps every ĉ_0 to [−1, 1], the range of labels.
  bool clip_x0 = true;

  void Bind(OptionsBinder& b);
  /// Throws Error naming the key and what it expects.
  void Check() const;
};

/// Turns noise c_T into confidences c_0 by calling a network a few times.
///
/// Example:
/// ```
/// auto sampler = MakeReverseSampler(options, schedule);
/// auto c0 = sampler->Sample([&](const torch::Tensor& c, double t) { return network->Denoise(context, c, t); }, c_T,
///                           [&](int step) { return NormalLike(c_T, rng.Fork("noise", step)); });
/// ```
/// Holds no state: one sampler may serve many threads. Self-conditioning needs nothing from it: the denoise function
/// keeps its last answer.
class ReverseSampler {
 public:
  virtual ~ReverseSampler() = default;

  /// `c_T` standard normal, any shape and floating type, usually [B, κ, N]; the answer has the same. Gradients are off.
  /// `noise` may be empty when IsStochastic() is false, else Error.
  torch::Tensor Sample(const DenoiseFunction& denoise, torch::Tensor c_T, const NoiseFunction& noise = {},
                       const StepObserver& observer = {}) const;

  /// Whether Sample draws noise after c_T.
  virtual bool IsStochastic() const = 0;
  /// Steps really made; see MakeTimeGrid. Each calls the network once, a second-order 2S step twice.
  int Steps() const { return static_cast<int>(grid_.size()) - 1; }
  const TimeGrid& grid() const { return grid_; }

 protected:
  ReverseSampler(TimeGrid grid, bool clip_x0) : grid_(std::move(grid)), clip_x0_(clip_x0) {}
  virtual torch::Tensor Run(const DenoiseFunction& denoise, torch::Tensor c, const NoiseFunction& noise,
                            const StepObserver& observer) const = 0;

 private:
  TimeGrid grid_;
  bool clip_x0_;
};

/// Throws Error on bad options, steps > T included.
std::unique_ptr<ReverseSampler> MakeReverseSampler(const SamplerOptions& options, const NoiseSchedule& schedule);

}  // namespace diffsac
