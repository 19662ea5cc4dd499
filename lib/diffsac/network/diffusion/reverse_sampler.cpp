#include "diffsac/network/diffusion/reverse_sampler.h"

#include "diffsac/network/diffusion/confidence_rows.h"
#include "diffsac/network/diffusion/reverse_sampler_impl.h"

namespace diffsac {

template class ReverseSamplerOf<ConfidenceRows>;

void ReverseSamplerOptions::Bind(OptionsBinder& b) {
  b.Field("kind", kind)
      .Help(
          "`ddpm`: the posterior q(c_{t−1} | c_t, ĉ_0) of Ho et al. 2020, also over strided steps; `renoise`: the "
          "paper's update in its inference section, which is multistep consistency sampling (Song et al., ICML "
          "2023); `ddim`: Song et al., ICLR 2021; `dpm_solver_pp`: DPM-Solver++, as in the paper's experiments");
  b.Field("steps", steps, Within(1, 1e5)).Help("at most the schedule's T; `ddpm` as published takes all T");
  BindDpmSolver(b);
  b.Field("timestep_spacing", timestep_spacing)
      .Help("`linspace`, `leading`, `trailing`: equal steps of the index, as diffusers");
  b.Field("final_sigma", final_sigma)
      .Help("where the last step ends: `zero` on clean data (the answer is the last ĉ_0), `sigma_min` at index 0");
  b.Field("lambda_min_clipped", lambda_min_clipped)
      .Help(
          "timesteps with a smaller λ are left out, since the solver is unstable there with the cosine schedule; "
          "-1000 or less keeps all, and with it a zero-terminal-SNR schedule starts at exactly no signal");
  b.Field("ddim_eta", ddim_eta, Within(0.0, 1.0))
      .OnlyIf(kind == ReverseSamplerKind::kDdim, "kind: ddim")
      .Help("0: deterministic, 1: as noisy as ddpm");
  b.Field("clip_x0", clip_x0).Help("clamp every ĉ_0 to [−1, 1], the range of labels");
}

void ReverseSamplerOptions::BindDpmSolver(OptionsBinder& b) {
  const bool dpm = kind == ReverseSamplerKind::kDpmSolverPp;
  b.Field("order", order, Within(1, 2)).OnlyIf(dpm, "kind: dpm_solver_pp").Help("of the solver; 2: multistep (2M)");
  b.Field("lower_order_final", lower_order_final)
      .OnlyIf(dpm && order == 2, "kind: dpm_solver_pp of order 2")
      .Help("with fewer than 15 steps the last one is of order 1");
}

std::unique_ptr<ReverseSamplerOf<ConfidenceRows>> MakeConfidenceSampler(const ReverseSamplerOptions& options,
                                                                        const NoiseSchedule& schedule) {
  return MakeReverseSamplerOf<ConfidenceRows>(options, schedule);
}

}  // namespace diffsac
