#include "diffsac/geometry/square_bounds.h"

#include <algorithm>
#include <cmath>

#include "diffsac/geometry/lanes.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

// With coordinates and models rounded to single precision (u = 2⁻²⁴, |coordinate| ≤ 1, unit norm), a product sum of
// three terms such as (F x1)₁ errs by at most 4.6 √3 u, and x2ᵀ F x1 or (H x1)₁ − x2 (H x1)₃ by at most 25 u.
constexpr float kUnit = 5.9604645e-8f;
constexpr float kNumeratorError = 32.0f * kUnit;
constexpr float kLineError = 14.0f * kUnit;
/// Σ (|a| + error)² ≤ (1 + share) Σ a² + (1 + 1/share) Σ error²; the rest of the factor is for rounding.
constexpr float kShare = 1.0f / 512.0f;
constexpr float kSlopeFactor = 1.0f + 1.25f * kShare;
constexpr float kSlopeError = 1.25f * kLineError * kLineError / kShare;
/// Of the centre from the origin, in extents: beyond, the residuals' own rounding would count.
constexpr double kFarthest = 1e3;
/// Thresholds in normalised units whose squares are ordinary numbers.
constexpr double kLeastThreshold = 1e-9, kLargestThreshold = 1e9;

bool IsOrdinary(double threshold) { return threshold >= kLeastThreshold && threshold <= kLargestThreshold; }

/// Row-major, unit norm, single precision. False when the matrix has no direction.
bool RoundMatrix(const Eigen::Matrix3d& matrix, float* out) {
  const Matrix3Parameters unit = AsParameters(matrix);
  if (!unit.allFinite()) return false;
  for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(unit[i]);
  return true;
}

/// Of a number that errs by at most `error`, the least square.
inline float LeastSquare(float value, float error) {
  const float least = std::abs(value) - error;
  // Twice the positive part; a choice would keep the loops from being vectorised.
  const float positive = least + std::abs(least);
  return 0.25f * (positive * positive);
}

inline float SampsonBound(const float* f, float x1, float y1, float x2, float y2) {
  const float a = (f[0] * x1 + f[1] * y1) + f[2], b = (f[3] * x1 + f[4] * y1) + f[5];
  const float c = (f[6] * x1 + f[7] * y1) + f[8];
  const float d = (f[0] * x2 + f[3] * y2) + f[6], e = (f[1] * x2 + f[4] * y2) + f[7];
  const float slope = ((a * a + b * b) + (d * d + e * e)) * kSlopeFactor + 4.0f * kSlopeError;
  return LeastSquare((x2 * a + y2 * b) + c, kNumeratorError) / slope;
}

DIFFSAC_BOUND_CLONES
void SampsonSquares(const float* f, float factor, const float* const* columns, int count, float* out) {
  float model[9];
  std::copy_n(f, 9, model);
  const float *x1 = columns[0], *y1 = columns[1], *x2 = columns[2], *y2 = columns[3];
  float* __restrict squares = out;
  for (int i = 0; i < count; ++i) squares[i] = SampsonBound(model, x1[i], y1[i], x2[i], y2[i]) * factor;
}

/// Squares of differences of two products, in shares of the factors' squares: what rounding makes of them, times what
/// kShare leaves of an error's square.
constexpr float kCrossError = 1e-10f;
/// (a − error)² ≥ (1 − share) a² − error² / share: of the numerator, and with another share of the root behind it,
/// whose error is the larger.
constexpr float kShiftShare = 1.0f / 64.0f;
constexpr float kLeastFactor = 1.0f - 2.0f * kShare - kShiftShare;
constexpr float kShiftError = 2.0f * kNumeratorError * kNumeratorError / kShiftShare;

/// With J of the rounded model in place of J, J Jᵀ grows by `weight` in all directions at most, so that the distance of
/// the rounded errors is at most too small; the true errors are as far off as kNumeratorError, in units of √weight.
inline float HomographyBound(const float* h, float x1, float y1, float x2, float y2) {
  const float w = (h[6] * x1 + h[7] * y1) + h[8];
  const float across = x2 * w - ((h[0] * x1 + h[1] * y1) + h[2]), down = y2 * w - ((h[3] * x1 + h[4] * y1) + h[5]);
  const float p0 = x2 * h[6] - h[0], p1 = x2 * h[7] - h[1], q0 = y2 * h[6] - h[3], q1 = y2 * h[7] - h[4];
  const float weight = w * w * kSlopeFactor + 6.0f * kSlopeError;
  const float pp = p0 * p0 + p1 * p1, qq = q0 * q0 + q1 * q1, ee = across * across + down * down;
  const float a = across * q0 - down * p0, b = across * q1 - down * p1, cross = p0 * q1 - p1 * q0;
  const float least = kLeastFactor * ((a * a + b * b) + weight * ee) - kCrossError * (ee * (pp + qq));
  const float most = cross * cross * (kSlopeFactor * kSlopeFactor) + (pp * qq) * kCrossError +
                     weight * ((pp + qq) * kSlopeFactor + weight);
  const float square = 2.0f * (least / most - kShiftError / weight);
  return 0.5f * (square + std::abs(square));
}

DIFFSAC_BOUND_CLONES
void HomographySquares(const float* h, float factor, const float* const* columns, int count, float* out) {
  float model[9];
  std::copy_n(h, 9, model);
  const float *x1 = columns[0], *y1 = columns[1], *x2 = columns[2], *y2 = columns[3];
  float* __restrict squares = out;
  for (int i = 0; i < count; ++i) squares[i] = HomographyBound(model, x1[i], y1[i], x2[i], y2[i]) * factor;
}

/// Rounding of one term and its share of the sum.
constexpr double kTermSlack = 1e-6;

DIFFSAC_BOUND_CLONES
float SumMsac(const float* squares, const float* weights, int count) {
  return SumFloats<kBoundBlock>(
      squares, weights, count, [](float square) { return 1.0f - square; },
      [](float share) { return share > 0.0f ? share : 0.0f; });
}

}  // namespace

double MsacBound(const float* squares, const float* weights, int count) {
  return static_cast<double>(SumMsac(squares, weights, count)) + kTermSlack * count;
}

SquareBounds::SquareBounds(Kind kind, const double* const* columns, int count) : kind_(kind), columns_(count, 4) {
  double extent = 0.0, farthest = 0.0;
  for (int j = 0; j < 4; ++j) {
    const Eigen::Map<const Eigen::VectorXd> values(columns[j], count);
    if (count == 0 || !values.allFinite()) return;
    const double least = values.minCoeff(), most = values.maxCoeff();
    centre_[j] = 0.5 * least + 0.5 * most;
    extent = std::max(extent, 0.5 * most - 0.5 * least);
    farthest = std::max({farthest, std::abs(least), std::abs(most)});
  }
  const double scale = 1.0 / extent;
  if (!(extent > 0.0) || !std::isfinite(scale) || !(farthest * scale < kFarthest)) return;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < count; ++i) columns_(i, j) = static_cast<float>((columns[j][i] - centre_[j]) * scale);
  scale_ = scale;
}

bool SquareBounds::Prepare(const Matrix3Parameters& model, double threshold, Prepared* out) const {
  const double normalized = threshold * scale_;
  if (!(scale_ > 0.0) || !IsOrdinary(normalized)) return false;
  out->inverse_square = static_cast<float>(1.0 / (normalized * normalized));
  const Eigen::Matrix3d first = Normalization(0).Inverse();
  const Eigen::Matrix3d second =
      kind_ == Kind::kSampson ? Eigen::Matrix3d(Normalization(1).Inverse().transpose()) : Normalization(1).Matrix();
  return RoundMatrix(second * AsMatrix(model) * first, out->matrix);
}

void SquareBounds::operator()(const Prepared& model, int begin, int end, float* out) const {
  const float* columns[4];
  for (int j = 0; j < 4; ++j) columns[j] = columns_.col(j).data() + begin;
  const auto squares = kind_ == Kind::kSampson ? SampsonSquares : HomographySquares;
  squares(model.matrix, model.inverse_square, columns, end - begin, out);
}

}  // namespace diffsac
