#include "diffsac/geometry/sampson_equations.h"

#include <algorithm>
#include <cmath>

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
void AddBlocks(const double* f, const double* const* columns, const double* weights, int begin, int count,
               LaneSums* sums) {
  for (int block = begin; block < begin + count; block += kLanes) {
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
  const int whole = count - count % kLanes;
  AddBlocks(f, columns, weights, 0, whole, &sums);
  if (whole < count) {
    // The rest, filled up with copies of the last point at weight 0.
    double rest[4][kLanes], rest_weights[kLanes] = {};
    for (int l = 0; l < kLanes; ++l) {
      const int row = std::min(whole + l, count - 1);
      for (int i = 0; i < 4; ++i) rest[i][l] = columns[i][row];
      if (whole + l < count) rest_weights[l] = weights[row];
    }
    const double* rest_columns[4] = {rest[0], rest[1], rest[2], rest[3]};
    AddBlocks(f, rest_columns, rest_weights, 0, kLanes, &sums);
  }
  NormalEquations result;
  int pair = 0;
  for (int i = 0; i < 9; ++i) {
    result.gradient[i] = Total(sums.gradient[i]);
    for (int j = 0; j <= i; ++j, ++pair) result.normal(i, j) = result.normal(j, i) = Total(sums.normal[pair]);
  }
  return result;
}

}  // namespace diffsac
