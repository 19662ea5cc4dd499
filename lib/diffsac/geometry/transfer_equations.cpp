#include "diffsac/geometry/transfer_equations.h"

#include <cmath>

#include "diffsac/geometry/lane_blocks.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

constexpr int kLanes = 4;

/// With q qᵀ (6 values) times 1, p_0, p_1 and |p|², the blocks of JᵀJ are
/// [1, 0, −p_0; 0, 1, −p_1; −p_0, −p_1, |p|²] ⊗ q qᵀ. One sum for each of four neighbouring points.
struct LaneSums {
  double normal[4][6][kLanes];
  double gradient[3][3][kLanes];
};

/// Adds `count` points, a multiple of four.
DIFFSAC_VECTOR_CLONES
void AddBlocks(const double* h, const double* const* columns, const double* weights, int count, LaneSums* sums) {
  for (int block = 0; block < count; block += kLanes) {
    const double* w = weights + block;
    if (w[0] == 0.0 && w[1] == 0.0 && w[2] == 0.0 && w[3] == 0.0) continue;
    double factor[4][kLanes], pull[3][kLanes], q[3][kLanes], square[6][kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const double x = columns[0][block + l], y = columns[1][block + l];
      const double u = columns[2][block + l], v = columns[3][block + l];
      const double quotient = 1.0 / (h[6] * x + h[7] * y + h[8]);
      // What has no weight may be at infinity.
      const double inverse = w[l] > 0.0 ? quotient : 0.0;
      const double p0 = (h[0] * x + h[1] * y + h[2]) * inverse, p1 = (h[3] * x + h[4] * y + h[5]) * inverse;
      const double r0 = p0 - u, r1 = p1 - v;
      q[0][l] = x * inverse;
      q[1][l] = y * inverse;
      q[2][l] = inverse;
      factor[0][l] = w[l];
      factor[1][l] = w[l] * p0;
      factor[2][l] = w[l] * p1;
      factor[3][l] = w[l] * (p0 * p0 + p1 * p1);
      pull[0][l] = w[l] * r0;
      pull[1][l] = w[l] * r1;
      pull[2][l] = -w[l] * (r0 * p0 + r1 * p1);
    }
    int pair = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++pair)
        for (int l = 0; l < kLanes; ++l) square[pair][l] = q[i][l] * q[j][l];
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 6; ++k)
        for (int l = 0; l < kLanes; ++l) sums->normal[j][k][l] += factor[j][l] * square[k][l];
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < kLanes; ++l) sums->gradient[j][k][l] += pull[j][l] * q[k][l];
  }
}

double Total(const double (&lanes)[kLanes]) { return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]); }

}  // namespace

NormalEquations SumTransferEquations(const double* h, const double* const* columns, const double* weights, int count) {
  LaneSums sums = {};
  AddInBlocks<kLanes>(columns, weights, count,
                      [&](const double* const* c, const double* w, int size) { AddBlocks(h, c, w, size, &sums); });
  constexpr int kPair[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  NormalEquations result{Eigen::Matrix<double, 9, 9>::Zero(), Matrix3Parameters::Zero()};
  Eigen::Matrix<double, 9, 9>& m = result.normal;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int k = kPair[i][j];
      m(i, j) = m(3 + i, 3 + j) = Total(sums.normal[0][k]);
      m(i, 6 + j) = m(6 + i, j) = -Total(sums.normal[1][k]);
      m(3 + i, 6 + j) = m(6 + i, 3 + j) = -Total(sums.normal[2][k]);
      m(6 + i, 6 + j) = Total(sums.normal[3][k]);
      result.gradient[3 * i + j] = Total(sums.gradient[i][j]);
    }
  }
  return result;
}

DIFFSAC_VECTOR_CLONES
void TransferDistances(const double* h, const double* const* columns, int count, double* out) {
  const double m[9] = {h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8]};
  const double *x1 = columns[0], *y1 = columns[1], *x2 = columns[2], *y2 = columns[3];
  double* __restrict distances = out;
  for (int i = 0; i < count; ++i) {
    const double inverse = 1.0 / (m[6] * x1[i] + m[7] * y1[i] + m[8]);
    const double dx = (m[0] * x1[i] + m[1] * y1[i] + m[2]) * inverse - x2[i];
    const double dy = (m[3] * x1[i] + m[4] * y1[i] + m[5]) * inverse - y2[i];
    distances[i] = std::sqrt(dx * dx + dy * dy);
  }
}

}  // namespace diffsac
