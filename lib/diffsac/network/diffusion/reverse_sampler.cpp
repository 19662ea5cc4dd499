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
}

void ReverseSamplerOptions::BindDpmSolver(OptionsBinder& b) {
  const bool dpm = kind == ReverseSamplerKind::kDpmSolverPp;
  b.Field("order", order, Within(1, 2)).OnlyIf(dpm, "kind: dpm_solver_pp").Help("of the solver; 2: multistep (2M)");
}

std::unique_ptr<ReverseSamplerOf<ConfidenceRows>> MakeConfidenceSampler(const ReverseSamplerOptions& options,
                                                                        const NoiseSchedule& schedule) {
  return MakeReverseSamplerOf<ConfidenceRows>(options, schedule);
}

}  // namespace diffsac
