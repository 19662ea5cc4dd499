#include "diffsac/geometry/transfer_equations.h"

#include <algorithm>
#include <cmath>

#include "diffsac/geometry/equation_blocks.h"
#include "diffsac/geometry/lane_blocks.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

/// With q qᵀ (6 values) times 1, p_0, p_1 and |p|², the blocks of JᵀJ are
/// [1, 0, −p_0; 0, 1, −p_1; −p_0, −p_1, |p|²] ⊗ q qᵀ. One sum for each of four neighbouring points.
struct LaneSums {
  EquationLanes normal[4][6];
  EquationLanes gradient[3][3];
};

struct Block {
  alignas(sizeof(EquationLanes)) EquationColumn factor[4];
  alignas(sizeof(EquationLanes)) EquationColumn pull[3];
  alignas(sizeof(EquationLanes)) EquationColumn q[3];
  alignas(sizeof(EquationLanes)) EquationColumn square[6];
};

/// Terms of point i of the block. What has no weight may be at infinity; chosen by a product, since the compiler puts a
/// branch around a quotient whose use is chosen.
inline void SetTerms(const double* h, double x, double y, double u, double v, double w, int i, Block* out) {
  const double counts = w > 0.0 ? 1.0 : 0.0;
  const double inverse = counts / ((h[6] * x + h[7] * y + h[8]) * counts + (1.0 - counts));
  const double p0 = (h[0] * x + h[1] * y + h[2]) * inverse, p1 = (h[3] * x + h[4] * y + h[5]) * inverse;
  const double r0 = p0 - u, r1 = p1 - v;
  const double q[3] = {x * inverse, y * inverse, inverse};
  out->factor[0][i] = w;
  out->factor[1][i] = w * p0;
  out->factor[2][i] = w * p1;
  out->factor[3][i] = w * (p0 * p0 + p1 * p1);
  out->pull[0][i] = w * r0;
  out->pull[1][i] = w * r1;
  out->pull[2][i] = -w * (r0 * p0 + r1 * p1);
  for (int j = 0; j < 3; ++j) out->q[j][i] = q[j];
  out->square[0][i] = q[0] * q[0];
  out->square[1][i] = q[0] * q[1];
  out->square[2][i] = q[0] * q[2];
  out->square[3][i] = q[1] * q[1];
  out->square[4][i] = q[1] * q[2];
  out->square[5][i] = q[2] * q[2];
}

/// Adds `count` points, a multiple of four.
DIFFSAC_VECTOR_CLONES
void AddBlocks(const double* h, const double* const* columns, const double* weights, int count, LaneSums* sums) {
  Block block;
  double model[9];
  std::copy_n(h, 9, model);
  for (int begin = 0; begin < count; begin += kEquationBlock) {
    const int size = std::min(kEquationBlock, count - begin);
    const double *x = columns[0] + begin, *y = columns[1] + begin, *u = columns[2] + begin, *v = columns[3] + begin;
    for (int i = 0; i < size; ++i) SetTerms(model, x[i], y[i], u[i], v[i], weights[begin + i], i, &block);
    for (int j = 0; j < 4; ++j) AddProducts<6>(block.factor[j], block.square, size, sums->normal[j]);
    for (int j = 0; j < 3; ++j) AddProducts<3>(block.pull[j], block.q, size, sums->gradient[j]);
  }
}

}  // namespace

NormalEquations SumTransferEquations(const double* h, const double* const* columns, const double* weights, int count) {
  LaneSums sums = {};
  AddInBlocks<kEquationLanes>(columns, weights, count, [&](const double* const* c, const double* w, int size) {
    AddBlocks(h, c, w, size, &sums);
  });
  constexpr int kPair[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  NormalEquations result{Eigen::Matrix<double, 9, 9>::Zero(), Matrix3Parameters::Zero()};
  Eigen::Matrix<double, 9, 9>& m = result.normal;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int k = kPair[i][j];
      m(i, j) = m(3 + i, 3 + j) = TotalOf(sums.normal[0][k]);
      m(i, 6 + j) = m(6 + i, j) = -TotalOf(sums.normal[1][k]);
      m(3 + i, 6 + j) = m(6 + i, 3 + j) = -TotalOf(sums.normal[2][k]);
      m(6 + i, 6 + j) = TotalOf(sums.normal[3][k]);
      result.gradient[3 * i + j] = TotalOf(sums.gradient[i][j]);
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
