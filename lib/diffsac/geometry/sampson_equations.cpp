#include "diffsac/geometry/sampson_equations.h"

#include "diffsac/geometry/lane_blocks.h"
#include "diffsac/geometry/residual_jacobians.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

constexpr int kLanes = 4;
constexpr int kPairs = 45;  // i >= j of nine

/// One sum for each lane, one lane for each of four neighbouring points.
struct LaneSums {
  double normal[kPairs][kLanes];
  double gradient[9][kLanes];
};

/// Adds `count` points, a multiple of four.
DIFFSAC_VECTOR_CLONES
void AddBlocks(const double* f, const double* const* columns, const double* weights, int count, LaneSums* sums) {
  for (int block = 0; block < count; block += kLanes) {
    const double* w = weights + block;
    if (w[0] == 0.0 && w[1] == 0.0 && w[2] == 0.0 && w[3] == 0.0) continue;
    double g[9][kLanes], r[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const double x1 = columns[0][block + l], y1 = columns[1][block + l];
      const double x2 = columns[2][block + l], y2 = columns[3][block + l];
      const double point[4] = {x1, y1, x2, y2};
      double gradient[9];
      r[l] = SampsonResidual(f, point, gradient);
      for (int i = 0; i < 9; ++i) g[i][l] = gradient[i];
    }
    int pair = 0;
    for (int i = 0; i < 9; ++i) {
      double scaled[kLanes];
      for (int l = 0; l < kLanes; ++l) scaled[l] = w[l] * g[i][l];
      for (int l = 0; l < kLanes; ++l) sums->gradient[i][l] += scaled[l] * r[l];
      for (int j = 0; j <= i; ++j, ++pair)
        for (int l = 0; l < kLanes; ++l) sums->normal[pair][l] += scaled[l] * g[j][l];
    }
  }
}

double Total(const double (&lanes)[kLanes]) { return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]); }

}  // namespace

NormalEquations SumSampsonEquations(const double* f, const double* const* columns, const double* weights, int count) {
  LaneSums sums = {};
  AddInBlocks<kLanes>(columns, weights, count,
                      [&](const double* const* c, const double* w, int size) { AddBlocks(f, c, w, size, &sums); });
  NormalEquations result;
  int pair = 0;
  for (int i = 0; i < 9; ++i) {
    result.gradient[i] = Total(sums.gradient[i]);
    for (int j = 0; j <= i; ++j, ++pair) result.normal(i, j) = result.normal(j, i) = Total(sums.normal[pair]);
  }
  return result;
}

}  // namespace diffsac
