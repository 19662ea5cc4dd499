#include "diffsac/geometry/homography.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "diffsac/geometry/homography_sampson.h"
#include "diffsac/geometry/least_eigenvector.h"
#include "diffsac/geometry/vector_clones.h"
#include "diffsac/geometry/weighted_pairs.h"

namespace diffsac {
namespace {

/// Sine of the smallest angle in a triangle of the minimal set that is no line yet.
constexpr double kMinSine = 1e-7;

/// Twice the signed area of a triangle; 0 when the points are collinear.
double SignedArea(const double* p, const double* q, const double* r) {
  const double ax = q[0] - p[0], ay = q[1] - p[1], bx = r[0] - p[0], by = r[1] - p[1];
  const double area = ax * by - ay * bx;
  const double lengths = (ax * ax + ay * ay) * (bx * bx + by * by);
  return area * area > kMinSine * kMinSine * lengths ? area : 0.0;
}

/// Areas of the four triangles; area[i] leaves out point i. False when one vanishes.
bool SignedAreas(const double (*points)[4], int offset, double area[4]) {
  const double* p[4];
  for (int i = 0; i < 4; ++i) p[i] = points[i] + offset;
  area[0] = SignedArea(p[1], p[2], p[3]);
  area[1] = SignedArea(p[0], p[2], p[3]);
  area[2] = SignedArea(p[0], p[1], p[3]);
  area[3] = SignedArea(p[0], p[1], p[2]);
  return area[0] != 0.0 && area[1] != 0.0 && area[2] != 0.0 && area[3] != 0.0;
}

/// Columns λ_i (x_i, y_i, 1), i = 0..2, that sum to a multiple of the fourth point; λ by Cramer's rule is the areas.
Eigen::Matrix3d CanonicalBasis(const double (*points)[4], int offset, const double area[4]) {
  const double lambda[3] = {area[0], -area[1], area[2]};
  Eigen::Matrix3d basis;
  for (int i = 0; i < 3; ++i) {
    basis(0, i) = lambda[i] * points[i][offset];
    basis(1, i) = lambda[i] * points[i][offset + 1];
    basis(2, i) = lambda[i];
  }
  return basis;
}

/// The adjugate, row-major: the inverse up to scale, also where that does not exist.
inline void Adjugate(const double* h, double* g) {
  g[0] = h[4] * h[8] - h[5] * h[7];
  g[1] = h[2] * h[7] - h[1] * h[8];
  g[2] = h[1] * h[5] - h[2] * h[4];
  g[3] = h[5] * h[6] - h[3] * h[8];
  g[4] = h[0] * h[8] - h[2] * h[6];
  g[5] = h[2] * h[3] - h[0] * h[5];
  g[6] = h[3] * h[7] - h[4] * h[6];
  g[7] = h[1] * h[6] - h[0] * h[7];
  g[8] = h[0] * h[4] - h[1] * h[3];
}

inline double SymmetricDistance(const double* h, const double* g, double x1, double y1, double x2, double y2) {
  const double w = (h[6] * x1 + h[7] * y1) + h[8];
  const double v = (g[6] * x2 + g[7] * y2) + g[8];
  // One division for both images: 1 / w = v / (w v).
  const double inverse = 1.0 / (w * v);
  const double to_second = inverse * v, to_first = inverse * w;
  const double dx2 = ((h[0] * x1 + h[1] * y1) + h[2]) * to_second - x2;
  const double dy2 = ((h[3] * x1 + h[4] * y1) + h[5]) * to_second - y2;
  const double dx1 = ((g[0] * x2 + g[1] * y2) + g[2]) * to_first - x1;
  const double dy1 = ((g[3] * x2 + g[4] * y2) + g[5]) * to_first - y1;
  return std::sqrt(0.5 * ((dx2 * dx2 + dy2 * dy2) + (dx1 * dx1 + dy1 * dy1)));
}

bool Denormalize(const Eigen::Matrix3d& h, const PairNormalization& normalization, Matrix3Parameters* out) {
  *out = AsParameters(normalization.second.Inverse() * h * normalization.first.Matrix());
  return out->allFinite();
}

}  // namespace

int Homography::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  PairNormalization normalization;
  if (points.cols() != 4 || !NormalizeSet(points, set, kMinimalSize, &normalization)) return 0;
  double p[4][4];
  for (int i = 0; i < 4; ++i) normalization.Apply(points.data() + 4 * static_cast<Eigen::Index>(set[i]), p[i]);
  double area1[4], area2[4];
  if (!SignedAreas(p, 0, area1) || !SignedAreas(p, 2, area2)) return 0;
  for (int i = 0; i < 4; ++i)
    if ((area1[i] > 0.0) != (area2[i] > 0.0)) return 0;
  const Eigen::Matrix3d basis1 = CanonicalBasis(p, 0, area1), basis2 = CanonicalBasis(p, 2, area2);
  // The adjugate is the inverse up to scale.
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = basis1;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> inverse;
  Adjugate(rows.data(), inverse.data());
  Eigen::Matrix3d h = basis2 * inverse;
  const double w = h(2, 0) * p[0][0] + h(2, 1) * p[0][1] + h(2, 2);
  if (w < 0.0) h = -h;
  return Denormalize(h, normalization, out) ? 1 : 0;
}

bool Homography::Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
  WeightedPairs pairs;
  if (!pairs.Gather(points, weights, kMinimalSize)) return false;
  // Rows (x1, 0, -u x1) and (0, x1, -v x1): sums of x1 x1ᵀ times 1, u, v and u² + v².
  const Eigen::Matrix<double, 4, 6> sums = pairs.TransferMoments();
  constexpr int kPair[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  Eigen::Matrix<double, 9, 9> moments = Eigen::Matrix<double, 9, 9>::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int k = kPair[i][j];
      moments(i, j) = moments(3 + i, 3 + j) = sums(0, k);
      moments(i, 6 + j) = moments(6 + i, j) = -sums(1, k);
      moments(3 + i, 6 + j) = moments(6 + i, 3 + j) = -sums(2, k);
      moments(6 + i, 6 + j) = sums(3, k);
    }
  }
  Parameters solution;
  if (!LeastEigenvector(moments, &solution)) return false;
  if (solution[8] < 0.0) solution = -solution;
  return Denormalize(AsMatrix(solution), pairs.normalization(), out);
}

void Homography::Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out) {
  HomographySampsonDistances(model.data(), columns, begin, end, out);
}

double Homography::Residual(const Parameters& model, const double* point) {
  return HomographySampsonError(model, point);
}

double Homography::CameraMismatch(const Parameters& model, const Eigen::Matrix3d& K1, const Eigen::Matrix3d& K2) {
  constexpr double kWorstMismatch = 1e6;
  const Eigen::Matrix3d h = K2.inverse() * AsMatrix(model) * K1;
  if (!h.allFinite()) return kWorstMismatch;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> squares;
  squares.computeDirect(h.transpose() * h, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d s = squares.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return s[2] - s[0] < kWorstMismatch * s[1] ? (s[2] - s[0]) / s[1] : kWorstMismatch;
}

double TransferError(const Matrix3Parameters& model, const double* point) {
  const double* h = model.data();
  const double w = h[6] * point[0] + h[7] * point[1] + h[8];
  const double dx = (h[0] * point[0] + h[1] * point[1] + h[2]) / w - point[2];
  const double dy = (h[3] * point[0] + h[4] * point[1] + h[5]) / w - point[3];
  return std::sqrt(dx * dx + dy * dy);
}

double HomographySampsonError(const Matrix3Parameters& model, const double* point) {
  return std::sqrt(HomographySampson(model.data(), point[0], point[1], point[2], point[3]).Square());
}

double SymmetricTransferError(const Matrix3Parameters& model, const double* point) {
  double inverse[9];
  Adjugate(model.data(), inverse);
  return SymmetricDistance(model.data(), inverse, point[0], point[1], point[2], point[3]);
}

DIFFSAC_VECTOR_CLONES
void SymmetricTransferErrors(const Matrix3Parameters& model, const double* const* columns, int begin, int end,
                             double* out) {
  double h[9], g[9];
  for (int i = 0; i < 9; ++i) h[i] = model[i];
  Adjugate(h, g);
  const double *x1 = columns[0] + begin, *y1 = columns[1] + begin, *x2 = columns[2] + begin, *y2 = columns[3] + begin;
  double* __restrict distances = out;
  const int count = end - begin;
  for (int i = 0; i < count; ++i) distances[i] = SymmetricDistance(h, g, x1[i], y1[i], x2[i], y2[i]);
}

}  // namespace diffsac
