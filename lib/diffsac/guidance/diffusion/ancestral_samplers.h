#pragma once

#include "diffsac/guidance/diffusion/sampling.h"
#include "diffsac/guidance/diffusion/time_grid.h"

namespace diffsac {

/// One step from `s` to the less noisy `t` with the linear form
///   c_t = from_x · c_s + from_x0 · ĉ_0 + from_noise · z.
struct LinearUpdate {
  double from_x = 0.0;
  double from_x0 = 0.0;
  double from_noise = 0.0;
};

/// The mean and deviation of q(c_t | c_s, ĉ_0), Ho et al. 2020 Eq. (7), for any two points.
LinearUpdate DdpmUpdate(const TimePoint& s, const TimePoint& t);

/// The forward process from ĉ_0 to t: nothing of c_s is kept.
LinearUpdate RenoiseUpdate(const TimePoint& s, const TimePoint& t);

/// Song et al., "Denoising diffusion implicit models", Eq. (12) and (16) with η.
LinearUpdate DdimUpdate(const TimePoint& s, const TimePoint& t, double eta);

}  // namespace diffsac
