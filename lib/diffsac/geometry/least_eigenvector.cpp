#include "diffsac/geometry/least_eigenvector.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace diffsac {
namespace {

constexpr int kSize = 9;
/// Added to the diagonal (of a matrix of trace one), so that the factors exist for a singular matrix too. A second
/// least eigenvalue below it leaves the vector open.
constexpr double kShift = 1e-13;
/// Rounds before the complete decomposition, which takes as long as about twice as many, does it.
constexpr int kMaxRounds = 12;

using Pair = double[kSize][2];

/// L Lᵀ with the inverse of the diagonal kept in its place. False for a pivot that is not positive.
bool Factorize(double (&a)[kSize][kSize]) {
  for (int j = 0; j < kSize; ++j) {
    double pivot = a[j][j];
    for (int k = 0; k < j; ++k) pivot -= a[j][k] * a[j][k];
    if (!(pivot > 0.0)) return false;
    const double inverse = 1.0 / std::sqrt(pivot);
    a[j][j] = inverse;
    for (int i = j + 1; i < kSize; ++i) {
      double sum = a[i][j];
      for (int k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
      a[i][j] = sum * inverse;
    }
  }
  return true;
}

/// Solves for two right-hand sides in place.
void Solve(const double (&l)[kSize][kSize], Pair& x) {
  for (int i = 0; i < kSize; ++i) {
    for (int k = 0; k < i; ++k)
      for (int c = 0; c < 2; ++c) x[i][c] -= l[i][k] * x[k][c];
    for (int c = 0; c < 2; ++c) x[i][c] *= l[i][i];
  }
  for (int i = kSize - 1; i >= 0; --i) {
    for (int c = 0; c < 2; ++c) x[i][c] *= l[i][i];
    for (int k = 0; k < i; ++k)
      for (int c = 0; c < 2; ++c) x[k][c] -= l[i][k] * x[i][c];
  }
}

double Dot(const Pair& a, int i, const Pair& b, int j) {
  double sum = 0.0;
  for (int k = 0; k < kSize; ++k) sum += a[k][i] * b[k][j];
  return sum;
}

/// One round of subspace iteration with the inverse: v := orthonormal basis of M⁻¹ v, turned so that its columns are
/// the Ritz vectors, the least eigenvalue's first. Returns the squared change of the first; sets the second's
/// eigenvalue.
double Iterate(const double (&l)[kSize][kSize], Pair& v, double* second) {
  Pair w;
  std::copy(&v[0][0], &v[0][0] + 2 * kSize, &w[0][0]);
  Solve(l, w);
  const double a = Dot(v, 0, w, 0), b = 0.5 * (Dot(v, 0, w, 1) + Dot(v, 1, w, 0)), d = Dot(v, 1, w, 1);
  const double angle = 0.5 * std::atan2(2.0 * b, a - d), c = std::cos(angle), s = std::sin(angle);
  *second = 1.0 / (a * s * s - 2.0 * b * s * c + d * c * c);
  for (int k = 0; k < kSize; ++k) {
    const double first = c * w[k][0] + s * w[k][1];
    w[k][1] = c * w[k][1] - s * w[k][0];
    w[k][0] = first;
  }
  const double length = std::sqrt(Dot(w, 0, w, 0));
  for (int k = 0; k < kSize; ++k) w[k][0] /= length;
  const double overlap = Dot(w, 0, w, 1);
  for (int k = 0; k < kSize; ++k) w[k][1] -= overlap * w[k][0];
  const double rest = std::sqrt(Dot(w, 1, w, 1));
  const double sign = Dot(v, 0, w, 0) < 0.0 ? -1.0 : 1.0;
  double change = 0.0;
  for (int k = 0; k < kSize; ++k) {
    const double difference = sign * w[k][0] - v[k][0];
    change += difference * difference;
    v[k][0] = w[k][0];
    v[k][1] = w[k][1] / rest;
  }
  return change;
}

/// The complete decomposition, for eigenvalues too close together to iterate.
bool ByDecomposition(const Eigen::Matrix<double, 9, 9>& scaled, Eigen::Matrix<double, 9, 1>* vector) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(scaled);
  if (solver.info() != Eigen::Success || !(solver.eigenvalues()[1] > kShift)) return false;
  *vector = solver.eigenvectors().col(0);
  return true;
}

}  // namespace

bool LeastEigenvector(const Eigen::Matrix<double, 9, 9>& matrix, Eigen::Matrix<double, 9, 1>* vector) {
  const double trace = matrix.trace();
  if (!(trace > 0.0) || !matrix.allFinite()) return false;
  const Eigen::Matrix<double, 9, 9> scaled = matrix / trace;
  double factor[kSize][kSize];
  Pair v;
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j < kSize; ++j) factor[i][j] = scaled(i, j) + (i == j ? kShift : 0.0);
    // Any two vectors do that are not orthogonal to the answer; these are orthonormal.
    v[i][0] = 1.0 / 3.0;
    v[i][1] = (i - 4.0) / std::sqrt(60.0);
  }
  if (!Factorize(factor)) return ByDecomposition(scaled, vector);
  constexpr double kConverged = 1e-28;
  for (int round = 0; round < kMaxRounds; ++round) {
    double second = 0.0;
    const double change = Iterate(factor, v, &second);
    if (!(change <= kConverged)) continue;
    if (!(second > 2.0 * kShift)) return false;
    for (int i = 0; i < kSize; ++i) (*vector)[i] = v[i][0];
    return true;
  }
  return ByDecomposition(scaled, vector);
}

}  // namespace diffsac
