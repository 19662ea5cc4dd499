#include "diffsac/geometry/six_points.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "diffsac/geometry/essential_constraint.h"
#include "diffsac/geometry/null_space.h"

namespace diffsac {
namespace {

/// Polynomials in x and y. Linear: x, y, 1; quadratic: x², xy, y², x, y, 1; cubic: x³, x²y, xy², y³, x², xy, y², x,
/// y, 1.
using Linear = Eigen::Array3d;
using Quadratic = Eigen::Array<double, 6, 1>;
using Cubic = Eigen::Array<double, 10, 1>;
/// Places of products.
constexpr int kOfLinear[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};
constexpr int kOfQuadratic[6][3] = {{0, 1, 4}, {1, 2, 5}, {2, 3, 6}, {4, 5, 7}, {5, 6, 8}, {7, 8, 9}};

using Matrix10 = Eigen::Matrix<double, 10, 10>;
using Basis = Eigen::Matrix<double, 9, 3>;

Quadratic Product(const Linear& a, const Linear& b) {
  Quadratic product = Quadratic::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) product[kOfLinear[i][j]] += a[i] * b[j];
  return product;
}

void AddProduct(const Quadratic& a, const Linear& b, double factor, Cubic* sum) {
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 3; ++j) (*sum)[kOfQuadratic[i][j]] += factor * a[i] * b[j];
}

/// F = x basis[0] + y basis[1] + basis[2], entry by entry.
struct Combination {
  Linear f[3][3];

  explicit Combination(const Basis& basis) {
    for (int i = 0; i < 9; ++i) f[i / 3][i % 3] = basis.row(i).transpose().array();
  }

  Cubic Determinant() const {
    Cubic determinant = Cubic::Zero();
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      AddProduct(Product(f[1][a], f[2][b]) - Product(f[1][b], f[2][a]), f[0][k], 1.0, &determinant);
    }
    return determinant;
  }

  /// Adds 2 G Q F − tr(G Q) F, G being the Gram matrix of columns [from, to), to the coefficients of the powers of w:
  /// `power`, and the one above for what the third row of F brings.
  void AddTraceConstraint(int from, int to, int power, Matrix10* coefficients) const {
    Quadratic gram[3][3];
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k <= i; ++k) {
        gram[i][k] = Quadratic::Zero();
        for (int c = from; c < to; ++c) gram[i][k] += Product(f[i][c], f[k][c]);
        gram[k][i] = gram[i][k];
      }
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
          Cubic sum = Cubic::Zero();
          AddProduct(gram[i][k], f[k][j], 2.0, &sum);
          AddProduct(gram[k][k], f[i][j], -1.0, &sum);
          coefficients[power + (k == 2 ? 1 : 0)].row(3 * i + j) += sum.matrix().transpose();
        }
      }
    }
  }
};

/// The coefficients C of the constraints by powers of w.
template <UnknownFocal kUnknown>
struct Constraints;

/// w²: with g the third column of F, r its third row, F₃₃ (2 g r − F₃₃ F).
template <>
struct Constraints<UnknownFocal::kBoth> {
  static constexpr int kPowers = 3;
  static constexpr int kSize = 16;
  Matrix10 c[kPowers];

  explicit Constraints(const Combination& f) {
    for (Matrix10& power : c) power.setZero();
    f.AddTraceConstraint(0, 2, 0, c);
    f.AddTraceConstraint(2, 3, 1, c);
    c[0].row(9) = f.Determinant().matrix().transpose();
    for (int i = 0; i < 9; ++i)
      quotient.row(i) = (2.0 * Product(f.f[i / 3][2], f.f[2][i % 3]) - Product(f.f[2][2], f.f[i / 3][i % 3])).matrix();
    quotient.row(9).setZero();
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 3; ++j) factor(i, kOfQuadratic[i][j]) += f.f[2][2][j];
  }

  /// Its eigenvalues are f²: with u = factor v / f², C₀ f² v = −C₁ v − quotient u.
  Eigen::Matrix<double, kSize, kSize> Linearised() const {
    Eigen::Matrix<double, 10, kSize> right;
    right << c[1], quotient;
    Eigen::Matrix<double, kSize, kSize> matrix = Eigen::Matrix<double, kSize, kSize>::Zero();
    matrix.topRows<10>() = -c[0].partialPivLu().solve(right);
    matrix.template bottomLeftCorner<6, 10>() = factor;
    return matrix;
  }

 private:
  Eigen::Matrix<double, 10, 6> quotient;  ///< C₂ = quotient · factor: quadratics, and their products with F₃₃.
  Eigen::Matrix<double, 6, 10> factor = Eigen::Matrix<double, 6, 10>::Zero();
};

template <>
struct Constraints<UnknownFocal::kSecond> {
  static constexpr int kPowers = 2;
  static constexpr int kSize = 10;
  Matrix10 c[kPowers];

  explicit Constraints(const Combination& f) {
    for (Matrix10& power : c) power.setZero();
    f.AddTraceConstraint(0, 3, 0, c);
    c[0].row(9) = f.Determinant().matrix().transpose();
  }

  Matrix10 Linearised() const { return -c[0].partialPivLu().solve(c[1]); }
};

/// The null vector of C at f² as x, y, 1 up to scale, by inverse iteration.
template <UnknownFocal kUnknown>
Eigen::Vector3d SharesAt(const Constraints<kUnknown>& constraints, double square) {
  Matrix10 matrix = constraints.c[0];
  for (int power = 1; power < Constraints<kUnknown>::kPowers; ++power)
    matrix = (square * matrix + constraints.c[power]).eval();
  const Eigen::PartialPivLU<Matrix10> lu(matrix);
  Eigen::Matrix<double, 10, 1> v = Eigen::Matrix<double, 10, 1>::Ones();
  for (int i = 0; i < 2; ++i) v = lu.solve(v).normalized();
  // The monomials that hold most of it.
  constexpr int kPlaces[3][3] = {{0, 1, 4}, {2, 3, 6}, {7, 8, 9}};
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (const auto& places : kPlaces) {
    const Eigen::Vector3d shares(v[places[0]], v[places[1]], v[places[2]]);
    if (shares.squaredNorm() > best.squaredNorm()) best = shares;
  }
  return best.normalized();
}

/// E of a combination of null vectors and of log f.
template <UnknownFocal kUnknown>
struct FocalFamily {
  static constexpr int kUnknowns = 4, kShares = 3;
  Basis basis;

  Matrix3Parameters Entries(const Matrix3Parameters& f, double log_focal) const {
    const double inverse = std::exp(-log_focal);
    return WithFocals(f, kUnknown == UnknownFocal::kBoth ? inverse : 1.0, inverse);
  }
  Eigen::Matrix3d At(const Eigen::Vector4d& unknowns) const {
    return AsMatrix(Entries(basis * unknowns.head<3>(), unknowns[3]));
  }
  Eigen::Matrix3d Along(const Eigen::Vector4d& unknowns, const Eigen::Matrix3d& e, int k) const {
    if (k < 3) return AsMatrix(Entries(basis.col(k), unknowns[3]));
    Eigen::Matrix3d along = Eigen::Matrix3d::Zero();
    along.row(2) -= e.row(2);
    if (kUnknown == UnknownFocal::kBoth) along.col(2) -= e.col(2);
    return along;
  }
};

}  // namespace

template <UnknownFocal kUnknown>
int SolveSixPoints(const double (*points)[4], FocalParameters* out) {
  // A root's imaginary part that may be rounding, and what is left of the constraint of a solution, as shares.
  constexpr double kReal = 1e-4, kSolved = 1e-16;
  constexpr double kGreatest = kGreatestFocal * kGreatestFocal;
  double rows[6][9], null[3][9];
  for (int i = 0; i < 6; ++i) EpipolarRow(points[i], rows[i]);
  if (!OrthogonalComplement(rows, null)) return 0;
  const Basis basis = Eigen::Map<const Basis>(&null[0][0]);
  const Constraints<kUnknown> constraints{Combination(basis)};
  const auto matrix = constraints.Linearised();
  if (!matrix.allFinite()) return 0;
  const Eigen::EigenSolver<std::remove_const_t<decltype(matrix)>> solver(matrix, false);
  if (solver.info() != Eigen::Success) return 0;
  const FocalFamily<kUnknown> family{basis};
  int count = 0;
  for (const std::complex<double>& root : solver.eigenvalues()) {
    const double square = root.real();
    if (!(square * kGreatest > 1.0 && square < kGreatest) || std::abs(root.imag()) > kReal * square) continue;
    Eigen::Vector4d unknowns;
    unknowns << SharesAt(constraints, square), 0.5 * std::log(square);
    const double left = PolishEssential(family, &unknowns);
    const Eigen::Matrix3d e = family.At(unknowns);
    if (!(left <= kSolved * std::pow(e.squaredNorm(), 3)) || count == MaxSixPointSolutions(kUnknown)) continue;
    out[count] = AsFocalParameters(kUnknown, family.Entries(family.basis * unknowns.head<3>(), unknowns[3]),
                                   std::exp(unknowns[3]));
    if (out[count].allFinite()) ++count;
  }
  return count;
}

template int SolveSixPoints<UnknownFocal::kBoth>(const double (*)[4], FocalParameters*);
template int SolveSixPoints<UnknownFocal::kSecond>(const double (*)[4], FocalParameters*);

}  // namespace diffsac
