#include "diffsac/geometry/fundamental.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diffsac/geometry/null_space.h"
#include "diffsac/geometry/plane_and_parallax.h"
#include "diffsac/geometry/polynomial.h"
#include "diffsac/geometry/pose.h"

namespace diffsac {
namespace {

/// Normalised points of a minimal set, and the rows of their epipolar equations.
template <int N>
bool EpipolarRows(const PointMatrix& points, const int* set, PairNormalization* normalization, double (&p)[N][4],
                  double (&rows)[N][9]) {
  if (points.cols() != 4 || !NormalizeSet(points, set, N, normalization)) return false;
  for (int i = 0; i < N; ++i) {
    normalization->Apply(points.data() + 4 * static_cast<Eigen::Index>(set[i]), p[i]);
    EpipolarRow(p[i], rows[i]);
  }
  return true;
}

bool Denormalize(const Eigen::Matrix3d& f, const PairNormalization& normalization, Matrix3Parameters* out) {
  *out = AsParameters(normalization.second.Matrix().transpose() * f * normalization.first.Matrix());
  return out->allFinite();
}

double Determinant(const double* a, const double* b, const double* c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/// det(F + z G) = Σ c[i] zⁱ: determinants with rows taken from one or the other.
void DeterminantCubic(const double* f, const double* g, double c[4]) {
  c[0] = Determinant(f, f + 3, f + 6);
  c[1] = Determinant(g, f + 3, f + 6) + Determinant(f, g + 3, f + 6) + Determinant(f, f + 3, g + 6);
  c[2] = Determinant(f, g + 3, g + 6) + Determinant(g, f + 3, g + 6) + Determinant(g, g + 3, f + 6);
  c[3] = Determinant(g, g + 3, g + 6);
}

/// Turns the basis until G itself is no solution, which z could not express. There are at most three such directions.
void AvoidRootAtInfinity(double (&basis)[2][9], double c[4]) {
  for (int turn = 0; turn < 4; ++turn) {
    DeterminantCubic(basis[0], basis[1], c);
    if (std::abs(c[3]) > 1e-6 * (std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]))) return;
    for (int i = 0; i < 9; ++i) {
      const double f = basis[0][i], g = basis[1][i];
      basis[0][i] = 0.8 * f + 0.6 * g;
      basis[1][i] = 0.8 * g - 0.6 * f;
    }
  }
  DeterminantCubic(basis[0], basis[1], c);
}

/// Solutions in normalised coordinates.
int SolveSevenNormalized(double (&rows)[7][9], Eigen::Matrix3d* out) {
  double basis[2][9];
  if (!OrthogonalComplement(rows, basis)) return 0;
  double cubic[4], roots[3];
  AvoidRootAtInfinity(basis, cubic);
  const int count = SolveCubic(cubic, roots);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < 9; ++j) out[i](j / 3, j % 3) = basis[0][j] + roots[i] * basis[1][j];
  return count;
}

int SolveSeven(const PointMatrix& points, const int* set, bool oriented, Matrix3Parameters* out) {
  PairNormalization normalization;
  double p[7][4], rows[7][9];
  if (!EpipolarRows(points, set, &normalization, p, rows)) return 0;
  Eigen::Matrix3d solutions[3];
  const int found = SolveSevenNormalized(rows, solutions);
  int count = 0;
  for (int i = 0; i < found; ++i) {
    if (oriented && !SatisfiesOrientation(solutions[i], p, 7)) continue;
    if (Denormalize(solutions[i], normalization, out + count)) ++count;
  }
  return count;
}

}  // namespace

int SolveSevenPoints(const PointMatrix& points, const int* set, Matrix3Parameters* out) {
  return SolveSeven(points, set, false, out);
}

int Fundamental::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  return SolveSeven(points, set, true, out);
}

int Fundamental8::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  PairNormalization normalization;
  double p[8][4], rows[8][9], basis[1][9];
  if (!EpipolarRows(points, set, &normalization, p, rows) || !OrthogonalComplement(rows, basis)) return 0;
  Eigen::Matrix3d f;
  for (int j = 0; j < 9; ++j) f(j / 3, j % 3) = basis[0][j];
  return Denormalize(ClosestRankTwo(f), normalization, out) ? 1 : 0;
}

bool Fundamental::Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
  PairNormalization normalization;
  Eigen::Matrix3d f;
  if (!FitEpipolarMatrix(points, weights, &normalization, &f)) return false;
  return Denormalize(ClosestRankTwo(f), normalization, out);
}

int Fundamental::RecoverFromDegeneracy(const PointMatrix& points, const int* set, const Parameters& model,
                                       double threshold, Rng rng, Parameters* out, int* fits) {
  return RecoverFromPlane(points, set, kMinimalSize, model, threshold, rng, kMaxSolutions, out, fits);
}

int Fundamental8::RecoverFromDegeneracy(const PointMatrix& points, const int* set, const Parameters& model,
                                        double threshold, Rng rng, Parameters* out, int* fits) {
  return RecoverFromPlane(points, set, kMinimalSize, model, threshold, rng, kMaxSolutions, out, fits);
}

/// Of a matrix of rank 1, and of what is no matrix.
constexpr double kWorstMismatch = 1e6;

double Fundamental::CameraMismatch(const Parameters& model, const Eigen::Matrix3d& K1, const Eigen::Matrix3d& K2) {
  const Eigen::Matrix3d e = K2.transpose() * AsMatrix(model) * K1;
  // Of rank 2: s₁² + s₂² = |E|², s₁ s₂ = |cofactors of E|.
  const double sum = e.squaredNorm();
  const double product = std::sqrt(e.col(0).cross(e.col(1)).squaredNorm() + e.col(1).cross(e.col(2)).squaredNorm() +
                                   e.col(2).cross(e.col(0)).squaredNorm());
  // (s₁ − s₂)/s₂ = s₁ s₂/s₂² − 1, with 2 s₂² = sum − √(sum² − 4 product²), written without the difference.
  const double larger = 0.5 * (sum + std::sqrt(std::max(0.0, (sum - 2.0 * product) * (sum + 2.0 * product))));
  return larger < kWorstMismatch * product ? std::max(0.0, larger / product - 1.0) : kWorstMismatch;
}

}  // namespace diffsac
