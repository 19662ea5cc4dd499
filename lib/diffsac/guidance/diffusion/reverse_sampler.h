#pragma once

#include <memory>
#include <string>
#include <utility>

#include "diffsac/core/enum_names.h"
#include "diffsac/guidance/diffusion/noise_schedule.h"
#include "diffsac/guidance/diffusion/sampling.h"
#include "diffsac/guidance/diffusion/time_grid.h"

namespace diffsac {

/// The paper describes three reverse processes that differ (its Algorithm 2, p_θ with √α_t, and a re-noising update),
/// so each reading that is a sampler has a name.
///   kDdpm         "ddpm": the posterior q(c_{t−1} | c_t, ĉ_0) of Ho et al. 2020, also over strided steps
///   kRenoise      "renoise": the paper's update in its inference section, c_{t−1} = √ᾱ_{t−1} ĉ_0 + √(1 − ᾱ_{t−1}) z,
///                 which is multistep consistency sampling (Song et al., ICML 2023)
///   kDdim         "ddim": Song et al., ICLR 2021
///   kDpmSolverPp  "dpm_solver_pp": DPM-Solver++ (the paper's experiments use it)
enum class ReverseSamplerKind { kDdpm, kRenoise, kDdim, kDpmSolverPp };
template <>
inline constexpr auto kEnumNames<ReverseSamplerKind> =
    NamesOf<ReverseSamplerKind>({{ReverseSamplerKind::kDdpm, "ddpm"},
                                 {ReverseSamplerKind::kRenoise, "renoise"},
                                 {ReverseSamplerKind::kDdim, "ddim"},
                                 {ReverseSamplerKind::kDpmSolverPp, "dpm_solver_pp"}});

/// How confidences are drawn.
struct ReverseSamplerOptions {
  ReverseSamplerKind kind = ReverseSamplerKind::kDpmSolverPp;
  /// Steps, at most the schedule's T. `ddpm` as published takes all T.
  int steps = 10;
  /// dpm_solver_pp: 1, or 2 (2M: from the previous step's prediction).
  int order = 2;
  TimestepSpacing timestep_spacing = TimestepSpacing::kLinspace;
  FinalSigma final_sigma = FinalSigma::kZero;
  /// dpm_solver_pp of order 2 with fewer than 15 steps: the last one is of order 1.
  bool lower_order_final = true;
  /// Timesteps with a smaller λ are left out, since the solver is unstable there with the cosine schedule; -1000 or
  /// less keeps all, and with it a zero-terminal-SNR schedule starts at exactly no signal.
  double lambda_min_clipped = -5.1;
  /// ddim: 0 deterministic, 1 as noisy as ddpm.
  double ddim_eta = 0.0;
  /// Clamps every ĉ_0 to [−1, 1], the range of labels.
  bool clip_x0 = true;
};

/// Turns noise c_T into confidences c_0 by calling a network a few times.
///
/// Example:
/// ```
/// auto sampler = MakeReverseSampler(options, schedule);
/// auto c0 = sampler->Sample([&](const torch::Tensor& c, double t) { return network->Denoise(context, c, t); }, c_T,
///                           [&](int step) { return NormalLike(c_T, rng.Fork("noise", step)); });
/// ```
/// Holds no state: one sampler may serve many threads.
template <class Value>
class ReverseSamplerOf {
 public:
  using DenoiseFunction = DenoiseFunctionOf<Value>;
  using NoiseFunction = NoiseFunctionOf<Value>;
  using StepObserver = StepObserverOf<Value>;

  virtual ~ReverseSamplerOf() = default;

  /// `c_T` standard normal, any shape and floating type, usually [B, κ, N]; the answer has the same. Gradients are off.
  /// `noise` may be empty when IsStochastic() is false, else Error.
  Value Sample(const DenoiseFunction& denoise, Value c_T, const NoiseFunction& noise = {},
               const StepObserver& observer = {}) const;

  /// Whether Sample draws noise after c_T.
  virtual bool IsStochastic() const = 0;
  /// Steps really made; see MakeTimeGrid. Each calls the network once.
  int Steps() const { return static_cast<int>(grid_.size()) - 1; }
  const TimeGrid& grid() const { return grid_; }

 protected:
  ReverseSamplerOf(TimeGrid grid, bool clip_x0) : grid_(std::move(grid)), clip_x0_(clip_x0) {}
  virtual Value Run(const DenoiseFunction& denoise, Value c, const NoiseFunction& noise,
                    const StepObserver& observer) const = 0;

 private:
  TimeGrid grid_;
  bool clip_x0_;
};

/// Throws Error on bad options, steps > T included. Defined in reverse_sampler_impl.h.
template <class Value>
std::unique_ptr<ReverseSamplerOf<Value>> MakeReverseSamplerOf(const ReverseSamplerOptions& options,
                                                              const NoiseSchedule& schedule);

}  // namespace diffsac
