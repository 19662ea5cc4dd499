#pragma once

#include <cstdint>

#include "diffsac/guidance/engine/kernels.h"

namespace diffsac {

// The loops of PooledBlock's training step between its matrix products (lab/torch/pooled_function.h), over rows of
// single precision that lie one after another, compiled for vectors. Unlike in geometry/ sums may be taken in another
// order on another processor, as in the matrix products. `width` is a multiple of 8.

/// Of each row its mean and the inverse of its standard deviation (variance + 1e-5).
void MomentsOfRows(const float* x, std::int64_t rows, std::int64_t width, float* mean, float* inverse);

/// u = (x − mean) · inverse · gain + shift.
void NormalizeRows(const float* x, const float* mean, const float* inverse, const float* gain, const float* shift,
                   std::int64_t rows, std::int64_t width, float* u);

/// The gradient of NormalizeRows and MomentsOfRows from that of u: adds to those of x, gain and shift.
void AddNormGradients(const float* du, const float* x, const float* mean, const float* inverse, const float* gain,
                      std::int64_t rows, std::int64_t width, float* dx, float* dgain, float* dshift);

/// One set of points under pooling: `real` says which rows count, null for all.
struct PooledSet {
  std::int64_t points, width;
  const bool* real;
};

/// Pools the rows of u: mean, maximum and, by the softmax of `attention` · u + `bias` over the points, kPoolingHeads
/// means. `shares` receives the softmax, points × heads.
void PoolSet(const PooledSet& set, const float* u, const float* attention, const float* bias, float* shares,
             float* pooled);

/// The gradient of PoolSet from that of `pooled`: adds to those of u, attention and bias. Points that tie for a maximum
/// have equal parts in it.
void AddPoolGradients(const PooledSet& set, const float* u, const float* attention, const float* shares,
                      const float* pooled, const float* dpooled, float* du, float* dattention, float* dbias);

/// The activation of each row of h plus `row`, gelu in its tanh form, and its slope.
void AddAndActivate(const float* row, const float* h, std::int64_t rows, std::int64_t width, float* activated,
                    float* slope);

/// gradient *= slope, and `sums` receives the sum of its rows.
void MultiplyAndSum(const float* slope, std::int64_t rows, std::int64_t width, float* gradient, float* sums);

/// sums += Σ of rows.
void AddSumOfRows(const float* x, std::int64_t rows, std::int64_t width, float* sums);

/// y = x + row, for each row of x.
void AddRow(const float* x, const float* row, std::int64_t rows, std::int64_t width, float* y);

}  // namespace diffsac
