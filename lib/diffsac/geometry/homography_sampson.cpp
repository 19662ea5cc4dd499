#include "diffsac/geometry/homography_sampson.h"

#include "diffsac/geometry/lanes.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

constexpr int kLanes = kEquationLanes;

/// The normal matrix is Σ [a, b, −c; b, d, −f; −c, −f, g] ⊗ x x ᵀ: six factors times the six products of x = (x1, y1,
/// 1). One sum for each of four neighbouring points.
struct LaneSums {
  double normal[6][6][kLanes];
  double gradient[9][kLanes];
};

/// Adds `count` points, a multiple of four.
DIFFSAC_VECTOR_CLONES
void AddBlocks(const double* h, const double* const* columns, const double* weights, int count, LaneSums* sums) {
  for (int block = 0; block < count; block += kLanes) {
    const double* weight = weights + block;
    if (weight[0] == 0.0 && weight[1] == 0.0 && weight[2] == 0.0 && weight[3] == 0.0) continue;
    double factor[6][kLanes], x[3][kLanes], gradient[9][kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const double u = columns[2][block + l], v = columns[3][block + l];
      x[0][l] = columns[0][block + l];
      x[1][l] = columns[1][block + l];
      x[2][l] = 1.0;
      const HomographySampson s(h, x[0][l], x[1][l], u, v);
      // What has no weight may be at infinity. Twice, as the square is.
      const double quotient = 2.0 * weight[l] / s.Determinant();
      const double inverse = weight[l] > 0.0 ? quotient : 0.0;
      // The inverse of J Jᵀ times weight, and with the errors the pull of both equations.
      const double a = inverse * ((s.q0 * s.q0 + s.q1 * s.q1) + s.w * s.w);
      const double b = -inverse * (s.p0 * s.q0 + s.p1 * s.q1);
      const double d = inverse * ((s.p0 * s.p0 + s.p1 * s.p1) + s.w * s.w);
      factor[0][l] = a;
      factor[1][l] = b;
      factor[2][l] = d;
      factor[3][l] = a * u + b * v;
      factor[4][l] = b * u + d * v;
      factor[5][l] = factor[3][l] * u + factor[4][l] * v;
      const double pull0 = a * s.e0 + b * s.e1, pull1 = b * s.e0 + d * s.e1;
      // Without the weight: how far the first point moves.
      const double share = weight[l] > 0.0 ? 0.5 / weight[l] : 0.0;
      const double dx = share * (pull0 * s.p0 + pull1 * s.q0);
      const double dy = share * (pull0 * s.p1 + pull1 * s.q1);
      const double third = pull0 * u + pull1 * v;
      const double turn = share * (pull0 * pull0 + pull1 * pull1) * s.w;
      gradient[0][l] = -pull0 * (x[0][l] - dx);
      gradient[1][l] = -pull0 * (x[1][l] - dy);
      gradient[2][l] = -pull0;
      gradient[3][l] = -pull1 * (x[0][l] - dx);
      gradient[4][l] = -pull1 * (x[1][l] - dy);
      gradient[5][l] = -pull1;
      gradient[6][l] = third * (x[0][l] - dx) - turn * x[0][l];
      gradient[7][l] = third * (x[1][l] - dy) - turn * x[1][l];
      gradient[8][l] = third - turn;
    }
    int pair = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++pair)
        for (int k = 0; k < 6; ++k)
          for (int l = 0; l < kLanes; ++l) sums->normal[k][pair][l] += factor[k][l] * (x[i][l] * x[j][l]);
    for (int k = 0; k < 9; ++k)
      for (int l = 0; l < kLanes; ++l) sums->gradient[k][l] += gradient[k][l];
  }
}

}  // namespace

DIFFSAC_VECTOR_CLONES
void HomographySampsonDistances(const double* h, const double* const* columns, int begin, int end, double* out) {
  double model[9];
  for (int i = 0; i < 9; ++i) model[i] = h[i];
  const double *x1 = columns[0] + begin, *y1 = columns[1] + begin, *x2 = columns[2] + begin, *y2 = columns[3] + begin;
  double* __restrict distances = out;
  const int count = end - begin;
  for (int i = 0; i < count; ++i)
    distances[i] = std::sqrt(HomographySampson(model, x1[i], y1[i], x2[i], y2[i]).Square());
}

NormalEquations SumHomographySampsonEquations(const double* h, const double* const* columns, const double* weights,
                                              int count) {
  LaneSums sums = {};
  AddInBlocks(columns, weights, count,
              [&](const double* const* c, const double* w, int size) { AddBlocks(h, c, w, size, &sums); });
  constexpr int kPair[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  constexpr int kFactor[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};
  NormalEquations result{Eigen::Matrix<double, 9, 9>::Zero(), Matrix3Parameters::Zero()};
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) {
      const double sign = (row < 6) == (column < 6) ? 1.0 : -1.0;
      const int k = kFactor[row / 3][column / 3];
      result.normal(row, column) = sign * TotalOf(sums.normal[k][kPair[row % 3][column % 3]]);
    }
    result.gradient[row] = TotalOf(sums.gradient[row]);
  }
  return result;
}

}  // namespace diffsac
