#include "lab/torch/pooled_kernels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

// As DIFFSAC_VECTOR_CLONES, and for AVX-512.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && !defined(__AVX2__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TRAINING_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define TRAINING_CLONES
#endif

namespace diffsac {
namespace {

constexpr float kNormEpsilon = 1e-5f;

// exp for |x| ≤ 40. Polynomial as in Cephes (Moshier).
inline float Exp(float x) {
  const auto power = static_cast<std::int32_t>(x * 1.44269504f + 64.5f) - 64;
  const auto whole = static_cast<float>(power);
  const float r = (x - whole * 0.693359375f) + whole * 2.12194440e-4f;
  const float p = ((((1.9875691500e-4f * r + 1.3981999507e-3f) * r + 8.3334519073e-3f) * r + 4.1665795894e-2f) * r +
                   1.6666665459e-1f) *
                      r +
                  5.0000001201e-1f;
  return (p * (r * r) + r + 1.0f) * std::bit_cast<float>((power + 127) << 23);
}

constexpr float kGeluScale = 0.7978845608f, kGeluCubic = 0.044715f;

inline float GeluTanh(float x) {
  const float z = 2.0f * kGeluScale * (x + kGeluCubic * x * x * x);
  const float lower = z > -36.0f ? z : -36.0f, clamped = lower < 36.0f ? lower : 36.0f;
  return 1.0f - 2.0f / (Exp(clamped) + 1.0f);
}

}  // namespace

TRAINING_CLONES
void MomentsOfRows(const float* x, std::int64_t rows, std::int64_t width, float* mean, float* inverse) {
  for (std::int64_t i = 0; i < rows; ++i, x += width) {
    float sum = 0.0f, squares = 0.0f;
#pragma omp simd reduction(+ : sum)
    for (std::int64_t c = 0; c < width; ++c) sum += x[c];
    const float m = sum / static_cast<float>(width);
#pragma omp simd reduction(+ : squares)
    for (std::int64_t c = 0; c < width; ++c) squares += (x[c] - m) * (x[c] - m);
    mean[i] = m;
    inverse[i] = 1.0f / std::sqrt(squares / static_cast<float>(width) + kNormEpsilon);
  }
}

TRAINING_CLONES
void NormalizeRows(const float* x, const float* mean, const float* inverse, const float* gain, const float* shift,
                   std::int64_t rows, std::int64_t width, float* __restrict u) {
  for (std::int64_t i = 0; i < rows; ++i, x += width, u += width) {
    const float m = mean[i], scale = inverse[i];
    for (std::int64_t c = 0; c < width; ++c) u[c] = (x[c] - m) * scale * gain[c] + shift[c];
  }
}

TRAINING_CLONES
void AddNormGradients(const float* du, const float* x, const float* mean, const float* inverse, const float* gain,
                      std::int64_t rows, std::int64_t width, float* __restrict dx, float* __restrict dgain,
                      float* __restrict dshift) {
  for (std::int64_t i = 0; i < rows; ++i, x += width, du += width, dx += width) {
    const float m = mean[i], scale = inverse[i];
    float sum = 0.0f, along = 0.0f;
#pragma omp simd reduction(+ : sum, along)
    for (std::int64_t c = 0; c < width; ++c) {
      const float normalized = (x[c] - m) * scale, d = du[c] * gain[c];
      sum += d;
      along += d * normalized;
      dgain[c] += du[c] * normalized;
      dshift[c] += du[c];
    }
    sum /= static_cast<float>(width), along /= static_cast<float>(width);
    for (std::int64_t c = 0; c < width; ++c) dx[c] += scale * (du[c] * gain[c] - sum - (x[c] - m) * scale * along);
  }
}

namespace {

// Scores of the heads, and their softmax over the points that are real.
void WriteShares(const PooledSet& set, float* shares) {
  for (int h = 0; h < kPoolingHeads; ++h) {
    float most = -3e38f, sum = 0.0f;
    for (std::int64_t i = 0; i < set.points; ++i)
      if (set.real == nullptr || set.real[i]) most = std::max(most, shares[i * kPoolingHeads + h]);
    for (std::int64_t i = 0; i < set.points; ++i) {
      float& share = shares[i * kPoolingHeads + h];
      share = set.real == nullptr || set.real[i] ? Exp(std::max(share - most, -40.0f)) : 0.0f;
      sum += share;
    }
    const float scale = sum > 0.0f ? 1.0f / sum : 0.0f;
    for (std::int64_t i = 0; i < set.points; ++i) shares[i * kPoolingHeads + h] *= scale;
  }
}

std::int64_t RealPoints(const PooledSet& set) {
  return set.real == nullptr ? set.points : std::count(set.real, set.real + set.points, true);
}

}  // namespace

TRAINING_CLONES
void PoolSet(const PooledSet& set, const float* u, const float* attention, const float* bias, float* shares,
             float* pooled) {
  const std::int64_t width = set.width;
  const float *a0 = attention, *a1 = a0 + width, *a2 = a1 + width, *a3 = a2 + width;
  for (std::int64_t i = 0; i < set.points; ++i) {
    const float* row = u + i * width;
    float s0 = bias[0], s1 = bias[1], s2 = bias[2], s3 = bias[3];
#pragma omp simd reduction(+ : s0, s1, s2, s3)
    for (std::int64_t c = 0; c < width; ++c)
      s0 += row[c] * a0[c], s1 += row[c] * a1[c], s2 += row[c] * a2[c], s3 += row[c] * a3[c];
    float* share = shares + i * kPoolingHeads;
    share[0] = s0, share[1] = s1, share[2] = s2, share[3] = s3;
  }
  WriteShares(set, shares);
  float* __restrict mean = pooled;
  float* __restrict most = pooled + width;
  float* __restrict head0 = pooled + 2 * width, * __restrict head1 = head0 + width;
  float* __restrict head2 = head1 + width, * __restrict head3 = head2 + width;
  static_assert(kPoolingHeads == 4);
  std::fill(pooled, pooled + (2 + kPoolingHeads) * width, 0.0f);
  std::fill(most, most + width, -1e9f);
  for (std::int64_t i = 0; i < set.points; ++i) {
    if (set.real != nullptr && !set.real[i]) continue;
    const float *row = u + i * width, *share = shares + i * kPoolingHeads;
    for (std::int64_t c = 0; c < width; ++c) {
      mean[c] += row[c];
      most[c] = most[c] > row[c] ? most[c] : row[c];
    }
#pragma omp simd
    for (std::int64_t c = 0; c < width; ++c) {
      const float value = row[c];
      head0[c] += share[0] * value, head1[c] += share[1] * value;
      head2[c] += share[2] * value, head3[c] += share[3] * value;
    }
  }
  const float scale = 1.0f / static_cast<float>(std::max<std::int64_t>(RealPoints(set), 1));
  for (std::int64_t c = 0; c < width; ++c) mean[c] *= scale;
}

namespace {

// Adds what the mean and the maximum give to the gradient of u.
TRAINING_CLONES
void AddMomentGradients(const PooledSet& set, const float* u, const float* most, const float* dpooled,
                        float* __restrict du) {
  const std::int64_t width = set.width;
  std::vector<float> ties(width, 0.0f), scaled(2 * width);
  float* __restrict count = ties.data();
  for (std::int64_t i = 0; i < set.points; ++i)
    if (set.real == nullptr || set.real[i])
      for (std::int64_t c = 0; c < width; ++c) count[c] += u[i * width + c] == most[c] ? 1.0f : 0.0f;
  const float share = 1.0f / static_cast<float>(std::max<std::int64_t>(RealPoints(set), 1));
  float* __restrict dmean = scaled.data(), * __restrict dmost = scaled.data() + width;
  for (std::int64_t c = 0; c < width; ++c) {
    dmean[c] = dpooled[c] * share;
    dmost[c] = dpooled[width + c] / std::max(count[c], 1.0f);
  }
  for (std::int64_t i = 0; i < set.points; ++i)
    if (set.real == nullptr || set.real[i])
      for (std::int64_t c = 0; c < width; ++c)
        du[i * width + c] += dmean[c] + (u[i * width + c] == most[c] ? dmost[c] : 0.0f);
}

}  // namespace

TRAINING_CLONES
void AddPoolGradients(const PooledSet& set, const float* u, const float* attention, const float* shares,
                      const float* pooled, const float* dpooled, float* du, float* dattention, float* dbias) {
  const std::int64_t width = set.width;
  AddMomentGradients(set, u, pooled + width, dpooled, du);
  const float *dheads = dpooled + 2 * width, *heads = pooled + 2 * width;
  const float *d0 = dheads, *d1 = d0 + width, *d2 = d1 + width, *d3 = d2 + width;
  const float *a0 = attention, *a1 = a0 + width, *a2 = a1 + width, *a3 = a2 + width;
  float *g0 = dattention, *g1 = g0 + width, *g2 = g1 + width, *g3 = g2 + width;
  // A softmax's gradient is taken against its mean, which is the pooled row along its own gradient.
  float m0 = 0.0f, m1 = 0.0f, m2 = 0.0f, m3 = 0.0f;
#pragma omp simd reduction(+ : m0, m1, m2, m3)
  for (std::int64_t c = 0; c < width; ++c) {
    m0 += heads[c] * d0[c], m1 += heads[width + c] * d1[c];
    m2 += heads[2 * width + c] * d2[c], m3 += heads[3 * width + c] * d3[c];
  }
  for (std::int64_t i = 0; i < set.points; ++i) {
    if (set.real != nullptr && !set.real[i]) continue;
    const float *row = u + i * width, *share = shares + i * kPoolingHeads;
    float* drow = du + i * width;
    float s0 = -m0, s1 = -m1, s2 = -m2, s3 = -m3;
#pragma omp simd reduction(+ : s0, s1, s2, s3)
    for (std::int64_t c = 0; c < width; ++c)
      s0 += row[c] * d0[c], s1 += row[c] * d1[c], s2 += row[c] * d2[c], s3 += row[c] * d3[c];
    const float p0 = share[0], p1 = share[1], p2 = share[2], p3 = share[3];
    s0 *= p0, s1 *= p1, s2 *= p2, s3 *= p3;
    dbias[0] += s0, dbias[1] += s1, dbias[2] += s2, dbias[3] += s3;
#pragma omp simd
    for (std::int64_t c = 0; c < width; ++c) {
      const float value = row[c];
      drow[c] +=
          (p0 * d0[c] + p1 * d1[c]) + (p2 * d2[c] + p3 * d3[c]) + (s0 * a0[c] + s1 * a1[c]) + (s2 * a2[c] + s3 * a3[c]);
      g0[c] += s0 * value, g1[c] += s1 * value, g2[c] += s2 * value, g3[c] += s3 * value;
    }
  }
}

TRAINING_CLONES
void AddAndActivate(const float* row, const float* h, std::int64_t rows, std::int64_t width,
                    float* __restrict activated, float* __restrict slope) {
  for (std::int64_t i = 0; i < rows; ++i, h += width, activated += width, slope += width)
    for (std::int64_t c = 0; c < width; ++c) {
      const float x = h[c] + row[c], t = GeluTanh(x), inner = kGeluScale * (1.0f + 3.0f * kGeluCubic * x * x);
      activated[c] = 0.5f * x * (1.0f + t);
      slope[c] = 0.5f * (1.0f + t) + 0.5f * x * (1.0f - t * t) * inner;
    }
}

TRAINING_CLONES
void MultiplyAndSum(const float* slope, std::int64_t rows, std::int64_t width, float* __restrict gradient,
                    float* __restrict sums) {
  std::fill(sums, sums + width, 0.0f);
  for (std::int64_t i = 0; i < rows; ++i, slope += width, gradient += width)
    for (std::int64_t c = 0; c < width; ++c) {
      gradient[c] *= slope[c];
      sums[c] += gradient[c];
    }
}

TRAINING_CLONES
void AddSumOfRows(const float* x, std::int64_t rows, std::int64_t width, float* __restrict sums) {
  for (std::int64_t i = 0; i < rows; ++i, x += width)
    for (std::int64_t c = 0; c < width; ++c) sums[c] += x[c];
}

TRAINING_CLONES
void AddRow(const float* x, const float* row, std::int64_t rows, std::int64_t width, float* __restrict y) {
  for (std::int64_t i = 0; i < rows; ++i, x += width, y += width)
    for (std::int64_t c = 0; c < width; ++c) y[c] = x[c] + row[c];
}

}  // namespace diffsac
