#include "diffsac/problem/residual_kernels.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

// Soft agreement falls off with this multiple of ε.
constexpr float kAgreementSigma = 0.5f;
// log1p(r/ε) reaches about 4.9 across the synthetic picture; this brings it to about unit range.
constexpr float kDistanceScale = 0.25f;
// ln 2 as a part with few bits, whose multiples are exact, and the rest.
constexpr float kLn2High = 0.693359375f, kLn2Low = -2.12194440e-4f;

// exp of what is at most 0; below -87, where single precision ends, that of -87. Polynomials as in Cephes (Moshier).
inline float ExpOfNegative(float x) {
  const float clamped = x > -87.0f ? x : -87.0f;
  const auto power = static_cast<std::int32_t>(clamped * 1.44269504f - 0.5f);
  const auto whole = static_cast<float>(power);
  const float r = (clamped - whole * kLn2High) - whole * kLn2Low;
  const float p = ((((1.9875691500e-4f * r + 1.3981999507e-3f) * r + 8.3334519073e-3f) * r + 4.1665795894e-2f) * r +
                   1.6666665459e-1f) *
                      r +
                  5.0000001201e-1f;
  return (p * (r * r) + r + 1.0f) * std::bit_cast<float>((power + 127) << 23);
}

// Logarithm of a number of at least 1.
inline float LogOfLarge(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  // Mantissa in [√½, √2).
  const std::int32_t shifted = bits - 0x3f3504f3;
  const auto exponent = static_cast<float>(shifted >> 23);
  const float f = std::bit_cast<float>((shifted & 0x007fffff) + 0x3f3504f3) - 1.0f;
  const float square = f * f;
  const float p = (((((((7.0376836292e-2f * f - 1.1514610310e-1f) * f + 1.1676998740e-1f) * f - 1.2420140846e-1f) * f +
                      1.4249322787e-1f) *
                         f -
                     1.6668057665e-1f) *
                        f +
                    2.0000714765e-1f) *
                       f -
                   2.4999993993e-1f) *
                      f +
                  3.3333331174e-1f;
  const float tail = f * square * p + exponent * kLn2Low - 0.5f * square;
  return f + tail + exponent * kLn2High;
}

}  // namespace

DIFFSAC_VECTOR_CLONES
void HyperplaneResiduals(const double* model, int dimension, const double* const* columns, int count,
                         double* __restrict residuals) {
  const double a = model[0], b = model[1], *x = columns[0], *y = columns[1];
  if (dimension == 2) {
    const double d = model[2];
    for (int i = 0; i < count; ++i) residuals[i] = std::abs(a * x[i] + b * y[i] + d);
  } else {
    const double c = model[2], d = model[3], *z = columns[2];
    for (int i = 0; i < count; ++i) residuals[i] = std::abs(a * x[i] + b * y[i] + c * z[i] + d);
  }
}

DIFFSAC_VECTOR_CLONES
void LimitResiduals(double most, int count, double* residuals) {
  for (int i = 0; i < count; ++i) residuals[i] = residuals[i] < most ? residuals[i] : most;
}

DIFFSAC_VECTOR_CLONES
double SumOfGains(const double* residuals, double inverse, int count) {
  // As many sums as hide the latency of an addition; the same grouping on every processor.
  constexpr int kSums = 16;
  double sums[kSums] = {};
  int i = 0;
  for (; i + kSums <= count; i += kSums)
    for (int l = 0; l < kSums; ++l) {
      const double gain = 1.0 - residuals[i + l] * residuals[i + l] * inverse;
      sums[l] += gain > 0.0 ? gain : 0.0;
    }
  for (; i < count; ++i) {
    const double gain = 1.0 - residuals[i] * residuals[i] * inverse;
    sums[0] += gain > 0.0 ? gain : 0.0;
  }
  double sum = 0.0;
  for (const double part : sums) sum += part;
  return sum;
}

DIFFSAC_VECTOR_CLONES
void WriteGains(const double* residuals, double inverse, int count, float* __restrict gains) {
  for (int i = 0; i < count; ++i) {
    const double gain = 1.0 - residuals[i] * residuals[i] * inverse;
    gains[i] = static_cast<float>(gain > 0.0 ? gain : 0.0);
  }
}

DIFFSAC_VECTOR_CLONES
void WriteAgreement(const double* residuals, double threshold, int count, float* __restrict agreement,
                    float* __restrict distance) {
  const double inverse = 1.0 / threshold;
  for (int i = 0; i < count; ++i) {
    const auto scaled = static_cast<float>(residuals[i] * inverse);
    agreement[i] = ExpOfNegative(scaled * scaled * (-0.5f / (kAgreementSigma * kAgreementSigma)));
    distance[i] = LogOfLarge(scaled + 1.0f) * kDistanceScale;
  }
}

}  // namespace diffsac
