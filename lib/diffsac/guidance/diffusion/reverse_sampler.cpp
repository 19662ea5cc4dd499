#include "diffsac/guidance/diffusion/reverse_sampler.h"

#include "diffsac/guidance/diffusion/confidence_rows.h"
#include "diffsac/guidance/diffusion/reverse_sampler_impl.h"

namespace diffsac {

template class ReverseSamplerOf<ConfidenceRows>;

std::unique_ptr<ReverseSamplerOf<ConfidenceRows>> MakeConfidenceSampler(const ReverseSamplerOptions& options,
                                                                        const NoiseSchedule& schedule) {
  return MakeReverseSamplerOf<ConfidenceRows>(options, schedule);
}

}  // namespace diffsac
