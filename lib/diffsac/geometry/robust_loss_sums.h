#pragma once

#include "diffsac/geometry/robust_loss.h"

namespace diffsac {

/// Σ w ρ(r²) over `count` residuals r ≥ 0 with weights w; several at a time for the truncated loss and the one over
/// scales. Up to rounding what RobustLoss says of each.
double SumLoss(const RobustLoss& loss, const double* residuals, const double* weights, int count);

/// w ρ'(r²) of each; `out` may be `residuals`.
void LossWeights(const RobustLoss& loss, const double* residuals, const double* weights, int count, double* out);

}  // namespace diffsac
