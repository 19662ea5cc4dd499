#include "lab/torch/tensor_sampler.h"

#include <torch/torch.h>

#include "diffsac/guidance/diffusion/reverse_sampler_impl.h"

namespace diffsac {

template class ReverseSamplerOf<torch::Tensor>;
template torch::Tensor RunDpmSolver(const TimeGrid&, const DpmSolverOptions&, const DenoiseFunction&, torch::Tensor,
                                    const StepObserver&);

std::unique_ptr<ReverseSampler> MakeReverseSampler(const ReverseSamplerOptions& options,
                                                   const NoiseSchedule& schedule) {
  return MakeReverseSamplerOf<torch::Tensor>(options, schedule);
}

}  // namespace diffsac
