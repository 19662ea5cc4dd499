#include "diffsac/geometry/sampson_equations.h"

#include <algorithm>

#include "diffsac/geometry/lanes.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

/// Each row of JᵀJ up to the diagonal, then the entry of Jᵀr. One sum for each of four neighbouring points.
struct LaneSums {
  EquationLanes rows[9][10];
};

struct Block {
  alignas(sizeof(EquationLanes)) EquationColumn jacobian[10];  ///< The nine derivatives and the residual.
  alignas(sizeof(EquationLanes)) EquationColumn scaled[9];     ///< Derivatives times the weight.
};

template <int kRow>
[[gnu::always_inline]] inline void AddRow(const Block& block, int size, LaneSums* sums) {
  AddProducts<kRow + 1>(block.scaled[kRow], block.jacobian, size, sums->rows[kRow]);
  AddProducts<1>(block.scaled[kRow], block.jacobian + 9, size, sums->rows[kRow] + 9);
}

/// Adds `count` points, a multiple of four.
DIFFSAC_VECTOR_CLONES
void AddBlocks(const double* f, const double* const* columns, const double* weights, int count, LaneSums* sums) {
  Block block;
  double model[9];
  std::copy_n(f, 9, model);
  for (int begin = 0; begin < count; begin += kEquationBlock) {
    const int size = std::min(kEquationBlock, count - begin);
    const double *x1 = columns[0] + begin, *y1 = columns[1] + begin, *x2 = columns[2] + begin, *y2 = columns[3] + begin;
    for (int i = 0; i < size; ++i) {
      const double point[4] = {x1[i], y1[i], x2[i], y2[i]};
      double gradient[9];
      block.jacobian[9][i] = SampsonResidual(model, point, gradient);
      for (int j = 0; j < 9; ++j) block.jacobian[j][i] = gradient[j];
      for (int j = 0; j < 9; ++j) block.scaled[j][i] = weights[begin + i] * gradient[j];
    }
    AddRow<0>(block, size, sums);
    AddRow<1>(block, size, sums);
    AddRow<2>(block, size, sums);
    AddRow<3>(block, size, sums);
    AddRow<4>(block, size, sums);
    AddRow<5>(block, size, sums);
    AddRow<6>(block, size, sums);
    AddRow<7>(block, size, sums);
    AddRow<8>(block, size, sums);
  }
}

}  // namespace

NormalEquations SumSampsonEquations(const double* f, const double* const* columns, const double* weights, int count) {
  LaneSums sums = {};
  AddInBlocks(columns, weights, count,
              [&](const double* const* c, const double* w, int size) { AddBlocks(f, c, w, size, &sums); });
  NormalEquations result;
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j <= i; ++j) result.normal(i, j) = result.normal(j, i) = TotalOf(sums.rows[i][j]);
    result.gradient[i] = TotalOf(sums.rows[i][9]);
  }
  return result;
}

}  // namespace diffsac
