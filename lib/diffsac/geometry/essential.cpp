#include "diffsac/geometry/essential.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diffsac/geometry/essential_constraint.h"
#include "diffsac/geometry/lanes.h"
#include "diffsac/geometry/null_space.h"
#include "diffsac/geometry/polynomial.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/rotation.h"
#include "diffsac/geometry/svd3.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

/// EquationLanes as templates take them.
using Lanes = double __attribute__((vector_size(kEquationLanes * sizeof(double))));

/// Polynomials in x, y, z, of numbers or of several neighbouring ones. Linear: x, y, z, 1.
template <class T>
struct Linear {
  T c[4];
};
/// x², y², z², xy, xz, yz, x, y, z, 1.
template <class T>
struct Quadratic {
  T c[10];
};
/// Nistér's order: x³ y³ x²y xy² x²z x² y²z y² xyz xy | xz² xz x | yz² yz y | z³ z² z 1.
constexpr int kCubicTerms = 20;
/// Sine of the angle between two rays below which noise may decide on which side they meet: a pixel at a focal length
/// of 1000.
constexpr double kMinParallax = 1e-3;
/// A cubic's coefficients.
using Row = double[kCubicTerms];

/// q += a b
template <class A, class B, class T>
[[gnu::always_inline]] inline void AddProduct(const Linear<A>& a, const Linear<B>& b, Quadratic<T>* q) {
  const A* u = a.c;
  const B* v = b.c;
  T* c = q->c;
  c[0] += u[0] * v[0];
  c[1] += u[1] * v[1];
  c[2] += u[2] * v[2];
  c[3] += u[0] * v[1] + u[1] * v[0];
  c[4] += u[0] * v[2] + u[2] * v[0];
  c[5] += u[1] * v[2] + u[2] * v[1];
  c[6] += u[0] * v[3] + u[3] * v[0];
  c[7] += u[1] * v[3] + u[3] * v[1];
  c[8] += u[2] * v[3] + u[3] * v[2];
  c[9] += u[3] * v[3];
}

/// row += q l
template <class Q>
[[gnu::always_inline]] inline void AddProduct(const Quadratic<Q>& quadratic, const Linear<Lanes>& linear,
                                              Lanes (&row)[kCubicTerms]) {
  const Q* q = quadratic.c;
  const Lanes* l = linear.c;
  row[0] += q[0] * l[0];
  row[1] += q[1] * l[1];
  row[2] += q[0] * l[1] + q[3] * l[0];
  row[3] += q[1] * l[0] + q[3] * l[1];
  row[4] += q[0] * l[2] + q[4] * l[0];
  row[5] += q[0] * l[3] + q[6] * l[0];
  row[6] += q[1] * l[2] + q[5] * l[1];
  row[7] += q[1] * l[3] + q[7] * l[1];
  row[8] += q[3] * l[2] + q[4] * l[1] + q[5] * l[0];
  row[9] += q[3] * l[3] + q[6] * l[1] + q[7] * l[0];
  row[10] += q[4] * l[2] + q[2] * l[0];
  row[11] += q[4] * l[3] + q[6] * l[2] + q[8] * l[0];
  row[12] += q[6] * l[3] + q[9] * l[0];
  row[13] += q[5] * l[2] + q[2] * l[1];
  row[14] += q[5] * l[3] + q[7] * l[2] + q[8] * l[1];
  row[15] += q[7] * l[3] + q[9] * l[1];
  row[16] += q[2] * l[2];
  row[17] += q[2] * l[3] + q[8] * l[2];
  row[18] += q[8] * l[3] + q[9] * l[2];
  row[19] += q[9] * l[3];
}

/// The ten cubic constraints on E = x basis[0] + y basis[1] + z basis[2] + basis[3], three entries of E at a time.
[[gnu::always_inline]] inline void CubicConstraints(const double (&basis)[4][9], Row (&rows)[10]) {
  Linear<Lanes> of_row[3], of_column[3];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 4; ++k) {
      const double* b = basis[k];
      of_row[i].c[k] = Lanes{b[3 * i], b[3 * i + 1], b[3 * i + 2], b[3 * i]};
      of_column[i].c[k] = Lanes{b[i], b[3 + i], b[6 + i], b[i]};
    }

  // E Eᵀ - tr(E Eᵀ) I / 2, times E.
  Quadratic<Lanes> gram[3] = {};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const Linear<double> entry{basis[0][3 * i + k], basis[1][3 * i + k], basis[2][3 * i + k], basis[3][3 * i + k]};
      AddProduct(entry, of_column[k], &gram[i]);
    }
  for (int t = 0; t < 10; ++t) {
    const double half_trace = 0.5 * (gram[0].c[t][0] + gram[1].c[t][1] + gram[2].c[t][2]);
    for (int i = 0; i < 3; ++i) gram[i].c[t][i] -= half_trace;
  }
  for (int i = 0; i < 3; ++i) {
    Lanes row[kCubicTerms] = {};
    for (int k = 0; k < 3; ++k) {
      Quadratic<double> entry;
      for (int t = 0; t < 10; ++t) entry.c[t] = gram[i].c[t][k];
      AddProduct(entry, of_row[k], row);
    }
    for (int t = 0; t < kCubicTerms; ++t)
      for (int j = 0; j < 3; ++j) rows[3 * i + j][t] = row[t][j];
  }

  const auto turned = [](const Linear<Lanes>& l, int first, double sign) {
    const int a = first, b = (first + 1) % 3, c = (first + 2) % 3;
    Linear<Lanes> result;
    for (int t = 0; t < 4; ++t) result.c[t] = sign * Lanes{l.c[t][a], l.c[t][b], l.c[t][c], l.c[t][a]};
    return result;
  };
  Quadratic<Lanes> minors = {};
  AddProduct(turned(of_row[1], 1, 1.0), turned(of_row[2], 2, 1.0), &minors);
  AddProduct(turned(of_row[1], 2, -1.0), turned(of_row[2], 1, 1.0), &minors);
  Lanes determinant[kCubicTerms] = {};
  AddProduct(minors, of_row[0], determinant);
  for (int t = 0; t < kCubicTerms; ++t) rows[9][t] = determinant[t][0] + determinant[t][1] + determinant[t][2];
}

/// row -= factor other, from the coefficient `begin` on, a multiple of four.
[[gnu::always_inline]] inline void Subtract(const Row& other, double factor, int begin, Row* row) {
  for (int t = begin; t < kCubicTerms; t += kEquationLanes)
    *reinterpret_cast<EquationLanes*>(*row + t) -= factor * LanesAt(other + t);
}

/// Elimination with row pivoting of the ten leading terms; afterwards rows 4 to 9 hold the terms x²z, x², y²z, y², xyz,
/// xy alone on their left. False when the leading block is singular.
[[gnu::always_inline]] inline bool Eliminate(Row (&rows)[10]) {
  for (int column = 0; column < 10; ++column) {
    int pivot = column;
    for (int i = column + 1; i < 10; ++i)
      if (std::abs(rows[i][column]) > std::abs(rows[pivot][column])) pivot = i;
    const double value = rows[pivot][column];
    if (!(std::abs(value) > 1e-14) || !std::isfinite(value)) return false;
    if (pivot != column) std::swap_ranges(rows[pivot], rows[pivot] + kCubicTerms, rows[column]);
    const double inverse = 1.0 / value;
    for (int t = column; t < kCubicTerms; ++t) rows[column][t] *= inverse;
    // What stands before the column is not asked for again.
    for (int i = column + 1; i < 10; ++i)
      Subtract(rows[column], rows[i][column], column - column % kEquationLanes, &rows[i]);
  }
  for (int column = 9; column > 4; --column) {
    for (int i = 4; i < column; ++i) {
      const double factor = rows[i][column];
      for (int t = 10; t < 12; ++t) rows[i][t] -= factor * rows[column][t];
      Subtract(rows[column], factor, 12, &rows[i]);
    }
  }
  return true;
}

DIFFSAC_VECTOR_CLONES
bool EliminatedConstraints(const double (&basis)[4][9], Row (&rows)[10]) {
  CubicConstraints(basis, rows);
  return Eliminate(rows);
}

/// A row of the 3 x 3 matrix B(z) with B (x, y, 1)ᵀ = 0: coefficients by ascending powers of z.
struct PolynomialRow {
  double x[4];
  double y[4];
  double one[5];
};

/// upper - z lower, where the leading terms cancel.
PolynomialRow SubtractShifted(const double* upper, const double* lower) {
  const double *a = upper + 10, *b = lower + 10;
  return {{a[2], a[1] - b[2], a[0] - b[1], -b[0]},
          {a[5], a[4] - b[5], a[3] - b[4], -b[3]},
          {a[9], a[8] - b[9], a[7] - b[8], a[6] - b[7], -b[6]}};
}

template <int N, int M>
void AddPolynomialProduct(const double (&a)[N], const double (&b)[M], double sign, double* out) {
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < M; ++j) out[i + j] += sign * a[i] * b[j];
}

/// det B(z), of degree 10.
void Determinant(const PolynomialRow (&b)[3], double out[11]) {
  std::fill(out, out + 11, 0.0);
  for (int k = 0; k < 3; ++k) {
    const PolynomialRow &p = b[(k + 1) % 3], &q = b[(k + 2) % 3];
    double minor[7] = {};
    AddPolynomialProduct(p.x, q.y, 1.0, minor);
    AddPolynomialProduct(p.y, q.x, -1.0, minor);
    AddPolynomialProduct(minor, b[k].one, 1.0, out);
  }
}

template <int N>
double Horner(const double (&c)[N], double z) {
  double value = c[N - 1];
  for (int i = N - 2; i >= 0; --i) value = value * z + c[i];
  return value;
}

/// The null vector (x, y, 1) of B(z) up to scale: the longest cross product of two of its rows.
Eigen::Vector3d NullVector(const PolynomialRow (&b)[3], double z) {
  double row[3][3];
  for (int i = 0; i < 3; ++i) {
    row[i][0] = Horner(b[i].x, z);
    row[i][1] = Horner(b[i].y, z);
    row[i][2] = Horner(b[i].one, z);
    const double length = std::sqrt(row[i][0] * row[i][0] + row[i][1] * row[i][1] + row[i][2] * row[i][2]);
    for (double& value : row[i]) value /= length;
  }
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double best_length = -1.0;
  for (int k = 0; k < 3; ++k) {
    const double *p = row[(k + 1) % 3], *q = row[(k + 2) % 3];
    const Eigen::Vector3d cross(p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]);
    const double length = cross.squaredNorm();
    if (length > best_length) {
      best_length = length;
      best = cross;
    }
  }
  return best;
}

/// Combinations of the null vectors of five epipolar equations.
struct NullSpaceFamily {
  static constexpr int kUnknowns = 4, kShares = 4;
  Eigen::Matrix<double, 9, 4> basis;

  Eigen::Matrix3d At(const Eigen::Vector4d& share) const { return AsMatrix(basis * share); }
  Eigen::Matrix3d Along(const Eigen::Vector4d&, const Eigen::Matrix3d&, int k) const { return AsMatrix(basis.col(k)); }
};

/// Reflects the basis by a fixed generic vector. Motions along an axis leave zeros in it, so that E could have no share
/// of the last vector, and x, y, z no finite value.
void MixBasis(double (&basis)[4][9]) {
  constexpr double kUnit[4] = {0.36, 0.48, 0.64, 0.48};
  for (int j = 0; j < 9; ++j) {
    double dot = 0.0;
    for (int k = 0; k < 4; ++k) dot += kUnit[k] * basis[k][j];
    for (int k = 0; k < 4; ++k) basis[k][j] -= 2.0 * dot * kUnit[k];
  }
}

/// Whether all points of visible parallax lie before both cameras for R and t or for R and -t.
bool AllInFront(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& t, const double (*points)[4], int count) {
  bool forward = true, backward = true;
  for (int i = 0; i < count && (forward || backward); ++i) {
    const double* p = points[i];
    const Eigen::Vector3d a = rotation.col(0) * p[0] + rotation.col(1) * p[1] + rotation.col(2), b(p[2], p[3], 1.0);
    const Eigen::Vector3d normal = a.cross(b);
    if (!(normal.squaredNorm() > kMinParallax * kMinParallax * a.squaredNorm() * b.squaredNorm())) continue;
    const double first = b.cross(t).dot(normal), second = a.cross(t).dot(normal);
    forward = forward && first > 0.0 && second > 0.0;
    backward = backward && first < 0.0 && second < 0.0;
  }
  return forward || backward;
}

void Gather(const PointMatrix& points, const int* set, double (*p)[4]) {
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 4; ++j) p[i][j] = points(set[i], j);
}

}  // namespace

int SolveFivePoints(const double (*points)[4], bool possible, Matrix3Parameters* out) {
  double rows[5][9], basis[4][9];
  for (int i = 0; i < 5; ++i) EpipolarRow(points[i], rows[i]);
  if (!OrthogonalComplement(rows, basis)) return 0;
  MixBasis(basis);
  alignas(sizeof(EquationLanes)) Row cubics[10];
  if (!EliminatedConstraints(basis, cubics)) return 0;
  const PolynomialRow b[3] = {SubtractShifted(cubics[4], cubics[5]), SubtractShifted(cubics[6], cubics[7]),
                              SubtractShifted(cubics[8], cubics[9])};
  double determinant[11], roots[10];
  Determinant(b, determinant);
  const int found = RealRoots10(determinant, roots);
  const NullSpaceFamily family{Eigen::Map<const Eigen::Matrix<double, 9, 4>>(&basis[0][0])};
  int count = 0;
  for (int i = 0; i < found; ++i) {
    const Eigen::Vector3d xy = NullVector(b, roots[i]);
    Eigen::Vector4d share = Eigen::Vector4d(xy[0], xy[1], roots[i] * xy[2], xy[2]).normalized();
    if (possible) {
      const Eigen::Matrix3d e = family.At(share);
      if (!SatisfiesOrientation(e, points, 5) || !SatisfiesCheirality(e, points, 5)) continue;
    }
    PolishEssential(family, &share);
    out[count] = family.basis * share;
    out[count] /= out[count].norm();
    if (out[count].allFinite()) ++count;
  }
  return count;
}

int SolveFivePoints(const PointMatrix& points, const int* set, Matrix3Parameters* out) {
  if (points.cols() != 4) return 0;
  double p[5][4];
  Gather(points, set, p);
  return SolveFivePoints(p, false, out);
}

int Essential::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  if (points.cols() != 4) return 0;
  double p[5][4];
  Gather(points, set, p);
  return SolveFivePoints(p, true, out);
}

bool SatisfiesCheirality(const Eigen::Matrix3d& e, const double (*points)[4], int count) {
  Eigen::Matrix3d cofactors;
  cofactors << e.col(1).cross(e.col(2)), e.col(2).cross(e.col(0)), e.col(0).cross(e.col(1));
  // All columns of the cofactors are multiples of t.
  Eigen::Index longest = 0;
  const double length = std::sqrt(cofactors.colwise().squaredNorm().maxCoeff(&longest));
  const Eigen::Vector3d t = cofactors.col(longest) * (std::sqrt(0.5) * e.norm() / length);
  // cof(E) - [t]ₓ E = |t|² R, and the twisted rotation with -t.
  const Eigen::Matrix3d turned = CrossMatrix(t) * e;
  return AllInFront(cofactors - turned, t, points, count) || AllInFront(cofactors + turned, t, points, count);
}

bool Essential::Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
  PairNormalization normalization;
  Eigen::Matrix3d e;
  if (!FitEpipolarMatrix(points, weights, &normalization, &e)) return false;
  e = normalization.second.Matrix().transpose() * e * normalization.first.Matrix();
  if (!e.allFinite()) return false;
  *out = AsParameters(ClosestEssential(e));
  return out->allFinite();
}

Eigen::Matrix3d ClosestEssential(const Eigen::Matrix3d& e) {
  const Svd3 svd = ComputeSvd3(e);
  const double mean = 0.5 * (svd.values[0] + svd.values[1]);
  return mean * svd.u.leftCols<2>() * svd.v.leftCols<2>().transpose();
}

}  // namespace diffsac
