#pragma once

namespace diffsac {

// Loops of the residual features over columns of points, compiled for vectors (geometry/vector_clones.h). What they
// write of a point depends on that point alone, not on where in the column it stands.

/// |n · x + d| of `count` points in 2 or 3 dimensions, a coordinate a column; `model` holds (n, d).
void HyperplaneResiduals(const double* model, int dimension, const double* const* columns, int count,
                         double* residuals);

/// The greater ones, and NaN, become `most`.
void LimitResiduals(double most, int count, double* residuals);

/// Σ max(0, 1 − r² · inverse).
double SumOfGains(const double* residuals, double inverse, int count);

/// Each max(0, 1 − r² · inverse).
void WriteGains(const double* residuals, double inverse, int count, float* gains);

/// With s = r / threshold: exp(−2 s²) and log(1 + s) / 4, both within 3e-7 of 1 or of their own size.
void WriteAgreement(const double* residuals, double threshold, int count, float* agreement, float* distance);

}  // namespace diffsac
