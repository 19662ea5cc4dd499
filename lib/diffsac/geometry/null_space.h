#pragma once

#include <algorithm>
#include <cmath>

namespace diffsac {

/// An orthonormal basis of the vectors orthogonal to the N given rows (N < M), by Householder reflections of the rows;
/// backward stable, without memory on the heap. The rows are overwritten. False when a row depends on those before it
/// up to `tolerance` (relative to its own length) or is not finite.
template <int N, int M>
bool OrthogonalComplement(double (&rows)[N][M], double (&basis)[M - N][M], double tolerance = 1e-10) {
  double beta[N];
  double length[N];
  for (int k = 0; k < N; ++k) {
    double sum = 0.0;
    for (int i = 0; i < M; ++i) sum += rows[k][i] * rows[k][i];
    length[k] = std::sqrt(sum);
  }
  for (int k = 0; k < N; ++k) {
    double sum = 0.0;
    for (int i = k; i < M; ++i) sum += rows[k][i] * rows[k][i];
    const double norm = std::sqrt(sum);
    if (!(norm > tolerance * length[k]) || !std::isfinite(norm)) return false;
    // The reflection v v^T beta maps the row's tail to -sign(head) norm e_k; this sign never cancels.
    const double head = rows[k][k];
    rows[k][k] = head + (head < 0.0 ? -norm : norm);
    beta[k] = 1.0 / (norm * (norm + std::abs(head)));
    for (int j = k + 1; j < N; ++j) {
      double dot = 0.0;
      for (int i = k; i < M; ++i) dot += rows[k][i] * rows[j][i];
      dot *= beta[k];
      for (int i = k; i < M; ++i) rows[j][i] -= dot * rows[k][i];
    }
  }
  for (int m = 0; m < M - N; ++m) {
    std::fill(basis[m], basis[m] + M, 0.0);
    basis[m][N + m] = 1.0;
    for (int k = N - 1; k >= 0; --k) {
      double dot = 0.0;
      for (int i = k; i < M; ++i) dot += rows[k][i] * basis[m][i];
      dot *= beta[k];
      for (int i = k; i < M; ++i) basis[m][i] -= dot * rows[k][i];
    }
  }
  return true;
}

/// The coefficients of x2ᵀ F x1 = 0 of a correspondence x1 y1 x2 y2 in the entries of F, row by row.
inline void EpipolarRow(const double* point, double (&row)[9]) {
  const double x1[3] = {point[0], point[1], 1.0}, x2[3] = {point[2], point[3], 1.0};
  for (int j = 0; j < 9; ++j) row[j] = x2[j / 3] * x1[j % 3];
}

}  // namespace diffsac
