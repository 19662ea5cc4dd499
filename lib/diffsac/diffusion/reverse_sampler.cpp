#include "diffsac/diffusion/reverse_sampler.h"

#include <torch/torch.h>

#include <functional>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/diffusion/ancestral_samplers.h"
#include "diffsac/diffusion/dpm_solver.h"

namespace diffsac {
namespace {

/// ddpm, renoise and ddim: they differ in three numbers a step.
class LinearSampler : public ReverseSampler {
 public:
  using Update = std::function<LinearUpdate(const TimePoint& s, const TimePoint& t)>;

  LinearSampler(TimeGrid grid, bool clip_x0, const Update& update) : ReverseSampler(std::move(grid), clip_x0) {
    for (int step = 0; step < Steps(); ++step) updates_.push_back(update(this->grid()[step], this->grid()[step + 1]));
  }

  bool IsStochastic() const override {
    for (const LinearUpdate& update : updates_) {
      if (update.from_noise > 0.0) return true;
    }
    return false;
  }

 protected:
  torch::Tensor Run(const DenoiseFunction& denoise, torch::Tensor c, const NoiseFunction& noise,
                    const StepObserver& observer) const override {
    for (int step = 0; step < Steps(); ++step) {
      const LinearUpdate& update = updates_[step];
      const auto c0_hat = denoise(c, grid()[step].t);
      if (observer) observer(step, grid()[step].t, c, c0_hat);
      auto next = update.from_x * c + update.from_x0 * c0_hat;
      if (update.from_noise > 0.0) next = next + update.from_noise * noise(step);
      c = next;
    }
    return c;
  }

 private:
  std::vector<LinearUpdate> updates_;
};

class DpmSolverSampler : public ReverseSampler {
 public:
  DpmSolverSampler(TimeGrid grid, bool clip_x0, const DpmSolverOptions& options, const NoiseSchedule& schedule)
      : ReverseSampler(std::move(grid), clip_x0), options_(options), schedule_(schedule) {}

  // One step onto clean data adds no noise.
  bool IsStochastic() const override { return options_.sde && (Steps() > 1 || grid().back().sigma > 0.0); }

 protected:
  torch::Tensor Run(const DenoiseFunction& denoise, torch::Tensor c, const NoiseFunction& noise,
                    const StepObserver& observer) const override {
    const auto to_point = [this](double lambda) {
      return TimePoint::FromLambda(schedule_.TimestepOfLambda(lambda), lambda);
    };
    return RunDpmSolver(grid(), options_, denoise, std::move(c), noise, observer, to_point);
  }

 private:
  DpmSolverOptions options_;
  NoiseSchedule schedule_;
};

}  // namespace

void SamplerOptions::Bind(OptionsBinder& b) {
  b.Field("kind", kind)
      .Help(
          "`ddpm`: the posterior q(c_{t−1} | c_t, ĉ_0) of Ho et al. 2020, also over strided steps; `renoise`: the "
          "paper's update in its inference section, which is multistep consistency sampling (Song et al., ICML "
          "2023); `ddim`: Song et al., ICLR 2021; `dpm_solver_pp`: DPM-Solver++, as in the paper's experiments");
  b.Field("steps", steps, AtLeast(1)).Help("at most the schedule's T; `ddpm` as published takes all T");
  BindDpmSolver(b);
  b.Field("timestep_spacing", timestep_spacing)
      .Help(
          "`linspace`, `leading`, `trailing`: of the index, as diffusers; `uniform_lambda`: of λ, at real-valued "
          "indices; `karras`, `lu`: as diffusers, steps of σ^(1/7) and of λ with rounded indices");
  b.Field("final_sigma", final_sigma)
      .Help("where the last step ends: `zero` on clean data (the answer is the last ĉ_0), `sigma_min` at index 0");
  b.Field("lambda_min_clipped", lambda_min_clipped)
      .Help(
          "timesteps with a smaller λ are left out, since the solver is unstable there with the cosine schedule; "
          "-1000 or less keeps all, and with it a zero-terminal-SNR schedule starts at exactly no signal");
  b.Field("ddim_eta", ddim_eta, Within(0.0, 1.0))
      .OnlyIf(kind == SamplerKind::kDdim, "kind: ddim")
      .Help("0: deterministic, 1: as noisy as ddpm");
  b.Field("clip_x0", clip_x0).Help("clamp every ĉ_0 to [−1, 1], the range of labels");
}

void SamplerOptions::BindDpmSolver(OptionsBinder& b) {
  const bool dpm = kind == SamplerKind::kDpmSolverPp;
  b.Field("order", order, Within(1, 2)).OnlyIf(dpm, "kind: dpm_solver_pp").Help("of the solver");
  b.Field("variant", variant)
      .OnlyIf(dpm && order == 2, "kind: dpm_solver_pp of order 2")
      .Help("`2M`: one network call a step, `2S`: two");
  const bool multistep = order == 2 && variant == DpmSolverVariant::k2M;
  b.Field("lower_order_final", lower_order_final)
      .OnlyIf(dpm && multistep, "kind: dpm_solver_pp of order 2, variant 2M")
      .Help("with fewer than 15 steps the last one is of order 1");
  b.Field("sde", sde).OnlyIf(dpm, "kind: dpm_solver_pp").Help("the stochastic variant (sde-dpmsolver++)");
  b.Require(!dpm || !sde || order == 1 || multistep, "sde", "variant 2M or order 1");
}

torch::Tensor ReverseSampler::Sample(const DenoiseFunction& denoise, torch::Tensor c_T, const NoiseFunction& noise,
                                     const StepObserver& observer) const {
  if (IsStochastic() && !noise) throw Error("sampler: a stochastic sampler was given no noise");
  const torch::NoGradGuard no_grad;
  if (!clip_x0_) return Run(denoise, std::move(c_T), noise, observer);
  const auto clipped = [&denoise](const torch::Tensor& c, double t) { return denoise(c, t).clamp(-1.0, 1.0); };
  return Run(clipped, std::move(c_T), noise, observer);
}

std::unique_ptr<ReverseSampler> MakeReverseSampler(const SamplerOptions& options, const NoiseSchedule& schedule) {
  CheckOptions(options);
  auto grid = MakeTimeGrid(schedule,
                           {options.steps, options.timestep_spacing, options.final_sigma, options.lambda_min_clipped});
  if (options.kind == SamplerKind::kDpmSolverPp) {
    const DpmSolverOptions solver{options.order, options.variant == DpmSolverVariant::k2M, options.lower_order_final,
                                  options.sde};
    return std::make_unique<DpmSolverSampler>(std::move(grid), options.clip_x0, solver, schedule);
  }
  LinearSampler::Update update = DdpmUpdate;
  if (options.kind == SamplerKind::kRenoise) update = RenoiseUpdate;
  if (options.kind == SamplerKind::kDdim) {
    update = [eta = options.ddim_eta](const TimePoint& s, const TimePoint& t) { return DdimUpdate(s, t, eta); };
  }
  return std::make_unique<LinearSampler>(std::move(grid), options.clip_x0, update);
}

}  // namespace diffsac
