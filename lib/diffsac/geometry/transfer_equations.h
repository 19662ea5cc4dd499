#pragma once

#include "diffsac/geometry/sampson_equations.h"

namespace diffsac {

/// Weighted sums over the transfer residuals (TransferResidual) of `count` points given as 4 columns; points of weight
/// 0 add nothing, wherever H sends them. Four points go side by side, as in SumSampsonEquations.
NormalEquations SumTransferEquations(const double* h, const double* const* columns, const double* weights, int count);

/// |H x1 - x2| of each.
void TransferDistances(const double* h, const double* const* columns, int count, double* out);

}  // namespace diffsac
