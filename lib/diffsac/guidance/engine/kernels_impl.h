// The kernels, compiled once for each set of instructions (kernels_avx512.cpp, …) in a namespace of its own. Nothing
// but C types and the compiler's intrinsics may be included here: an inline function of a library, compiled for a newer
// processor, could take the place of everybody's.

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "diffsac/guidance/engine/kernels.h"

namespace diffsac {
namespace DIFFSAC_KERNELS {
namespace {

#if defined(__AVX512F__)
constexpr int kLanes = 16, kTileRows = 12;
#elif defined(__AVX2__)
constexpr int kLanes = 8, kTileRows = 6;
#else
constexpr int kLanes = 4, kTileRows = 4;
#endif
constexpr int kTileVectors = 2;
constexpr int kTileColumns = kTileVectors * kLanes;
constexpr int kMaxWidth = 256;

using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using Unaligned = float __attribute__((vector_size(kLanes * sizeof(float)), aligned(4), may_alias));
using Integers = int __attribute__((vector_size(kLanes * sizeof(float))));

inline Lanes Load(const float* p) { return *reinterpret_cast<const Unaligned*>(p); }
inline void Store(float* p, Lanes value) { *reinterpret_cast<Unaligned*>(p) = value; }
inline Lanes Larger(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes Smaller(Lanes a, Lanes b) { return a < b ? a : b; }

/// The lanes' sum in halves: one after another would wait for each other.
inline float Sum(Lanes v) {
#if defined(__AVX512F__)
  v += __builtin_shufflevector(v, v, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7);
  v += __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11);
  v += __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13);
#elif defined(__AVX2__)
  v += __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3);
  v += __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5);
#else
  v += __builtin_shufflevector(v, v, 2, 3, 0, 1);
#endif
  return v[0] + v[1];
}

/// e^x to 2 units in the last place, after Cephes' expf; x is clamped to [−87, 80], within what a float can hold.
inline Lanes Exp(Lanes x) {
  constexpr float kLog2e = 1.44269504f, kLn2High = 0.693359375f, kLn2Low = -2.12194440e-4f;
  constexpr float kRound = 12582912.0f;  // 1.5 · 2^23: adding it leaves the nearest integer in the low bits
  x = Larger(Smaller(x, Lanes{} + 80.0f), Lanes{} - 87.0f);
  const Lanes rounded = x * kLog2e + kRound;
  const Lanes n = rounded - kRound;
  const Lanes r = (x - n * kLn2High) - n * kLn2Low;
  Lanes p = r * 1.9875691500e-4f + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  const Lanes y = p * (r * r) + r + 1.0f;
  return reinterpret_cast<Lanes>(reinterpret_cast<Integers>(y) + (reinterpret_cast<Integers>(rounded) << 23));
}

/// 1/x for x ≥ 1: the processor's estimate, better than 2^−11, and one step of Newton's; a division takes three times
/// as long.
inline Lanes Reciprocal(Lanes x) {
#if defined(__AVX512F__)
  const Lanes estimate = reinterpret_cast<Lanes>(_mm512_rcp14_ps(reinterpret_cast<__m512>(x)));
  return estimate * (2.0f - x * estimate);
#elif defined(__AVX2__)
  const Lanes estimate = reinterpret_cast<Lanes>(_mm256_rcp_ps(reinterpret_cast<__m256>(x)));
  return estimate * (2.0f - x * estimate);
#else
  return 1.0f / x;
#endif
}

/// x/2 (1 + tanh(√(2/π)(x + 0.044715 x³))) = x / (1 + e^(−2…)), LibTorch's gelu "tanh".
inline Lanes Gelu(Lanes x) {
  constexpr float kLinear = -1.5957691216f, kCubic = -0.0713548162f;  // −2 √(2/π), that times 0.044715
  return x * Reciprocal(1.0f + Exp(x * (kLinear + kCubic * (x * x))));
}

inline Lanes Sigmoid(Lanes x) { return Reciprocal(1.0f + Exp(-x)); }

/// y[kTileRows, kTileColumns] = x W + b of one tile; x: kTileRows rows, `in` apart.
inline void Tile(const float* x, int in, const float* weights, int out, const float* bias,
                 Lanes (&sum)[kTileRows][kTileVectors]) {
  for (int c = 0; c < kTileVectors; ++c) {
    const Lanes b = Load(bias + c * kLanes);
    for (int r = 0; r < kTileRows; ++r) sum[r][c] = b;
  }
  for (int k = 0; k < in; ++k) {
    Lanes w[kTileVectors];
    for (int c = 0; c < kTileVectors; ++c) w[c] = Load(weights + static_cast<long>(k) * out + c * kLanes);
    for (int r = 0; r < kTileRows; ++r) {
      const float value = x[r * in + k];
      for (int c = 0; c < kTileVectors; ++c) sum[r][c] += value * w[c];
    }
  }
}

/// out[row] = norm(x[row]).
inline void NormRow(const float* x, int width, PackedNorm norm, float* out) {
  Lanes sum = {}, squares = {};
  for (int i = 0; i < width; i += kLanes) sum += Load(x + i);
  const float mean = Sum(sum) / static_cast<float>(width);
  for (int i = 0; i < width; i += kLanes) {
    const Lanes centred = Load(x + i) - mean;
    squares += centred * centred;
  }
  const float inverse = 1.0f / __builtin_sqrtf(Sum(squares) / static_cast<float>(width) + 1e-5f);
  for (int i = 0; i < width; i += kLanes)
    Store(out + i, (Load(x + i) - mean) * inverse * Load(norm.scale + i) + Load(norm.shift + i));
}

/// y[out] = x[in] W + b of kVectors vectors of columns of one row.
template <int kVectors>
inline void RowColumns(const float* x, int in, int out, PackedLinear layer, int column, float* y) {
  Lanes sum[kVectors];
  for (int c = 0; c < kVectors; ++c) sum[c] = Load(layer.bias + column + c * kLanes);
  for (int k = 0; k < in; ++k) {
    const float* weights = layer.weights + static_cast<long>(k) * out + column;
    for (int c = 0; c < kVectors; ++c) sum[c] += x[k] * Load(weights + c * kLanes);
  }
  for (int c = 0; c < kVectors; ++c) Store(y + column + c * kLanes, sum[c]);
}

/// One row, whose weights are gone through once: several columns at a time, so that no addition waits for the last.
inline void LinearRow(const float* x, int in, int out, PackedLinear layer, float* y) {
  constexpr int kSeveral = 8;
  int column = 0;
  for (; column + kSeveral * kLanes <= out; column += kSeveral * kLanes)
    RowColumns<kSeveral>(x, in, out, layer, column, y);
  for (; column < out; column += kLanes) RowColumns<1>(x, in, out, layer, column, y);
}

void Linear(const float* x, int rows, int in, int out, PackedLinear layer, float* y) {
  int row = 0;
  for (; row + kTileRows <= rows; row += kTileRows) {
    const float* tile = x + static_cast<long>(row) * in;
    float* to = y + static_cast<long>(row) * out;
    int column = 0;
    for (; column + kTileColumns <= out; column += kTileColumns) {
      Lanes sum[kTileRows][kTileVectors];
      Tile(tile, in, layer.weights + column, out, layer.bias + column, sum);
      for (int r = 0; r < kTileRows; ++r)
        for (int c = 0; c < kTileVectors; ++c) Store(to + static_cast<long>(r) * out + column + c * kLanes, sum[r][c]);
    }
    for (; column < out; column += kLanes)
      for (int r = 0; r < kTileRows; ++r)
        RowColumns<1>(tile + static_cast<long>(r) * in, in, out, layer, column, to + static_cast<long>(r) * out);
  }
  for (; row < rows; ++row)
    LinearRow(x + static_cast<long>(row) * in, in, out, layer, y + static_cast<long>(row) * out);
}

/// Sums over rows with softmax weights whose maximum is not known yet: what was summed shrinks when it rises.
void Pool(const float* x, int rows, int width, const PackedPooledBlock& block, float* pooled) {
  constexpr int kRows = 64;
  float u[kRows * kMaxWidth], scores[kPoolingHeads][kRows];
  float* mean = pooled;
  float* largest = pooled + width;
  float* heads = pooled + 2 * width;
  for (int i = 0; i < width; ++i) mean[i] = 0.0f, largest[i] = -3.0e38f;
  for (int i = 0; i < kPoolingHeads * width; ++i) heads[i] = 0.0f;
  float top[kPoolingHeads], total[kPoolingHeads];
  for (int h = 0; h < kPoolingHeads; ++h) top[h] = -3.0e38f, total[h] = 0.0f;
  for (int begin = 0; begin < rows; begin += kRows) {
    const int count = rows - begin < kRows ? rows - begin : kRows;
    for (int r = 0; r < count; ++r) {
      float* row = u + r * width;
      NormRow(x + static_cast<long>(begin + r) * width, width, block.norm, row);
      Lanes dot[kPoolingHeads] = {};
      for (int i = 0; i < width; i += kLanes)
        for (int h = 0; h < kPoolingHeads; ++h) dot[h] += Load(row + i) * Load(block.attention + h * width + i);
      for (int h = 0; h < kPoolingHeads; ++h) scores[h][r] = Sum(dot[h]) + block.attention_bias[h];
    }
    for (int i = 0; i < width; i += kLanes) {
      Lanes sum = {}, most = Load(largest + i);
      for (int r = 0; r < count; ++r) {
        const Lanes value = Load(u + r * width + i);
        sum += value;
        most = Larger(most, value);
      }
      Store(mean + i, Load(mean + i) + sum);
      Store(largest + i, most);
    }
    for (int h = 0; h < kPoolingHeads; ++h) {
      float highest = top[h];
      for (int r = 0; r < count; ++r) highest = scores[h][r] > highest ? scores[h][r] : highest;
      const float shrink = Exp(Lanes{} + (top[h] - highest))[0];
      top[h] = highest;
      for (int r = count; r < kRows; ++r) scores[h][r] = -3.0e38f;
      Lanes sum = {};
      for (int r = 0; r < kRows; r += kLanes) {
        Lanes weight = Exp(Load(scores[h] + r) - highest);
        Store(scores[h] + r, weight);
        if (r + kLanes <= count)
          sum += weight;
        else
          for (int l = 0; r + l < count; ++l) sum[0] += weight[l];
      }
      total[h] = total[h] * shrink + Sum(sum);
      for (int i = 0; i < width; i += kLanes) Store(heads + h * width + i, shrink * Load(heads + h * width + i));
    }
    for (int i = 0; i < width; i += kLanes) {
      Lanes sum[kPoolingHeads] = {};
      for (int r = 0; r < count; ++r) {
        const Lanes value = Load(u + r * width + i);
        for (int h = 0; h < kPoolingHeads; ++h) sum[h] += scores[h][r] * value;
      }
      for (int h = 0; h < kPoolingHeads; ++h) {
        float* head = heads + h * width + i;
        Store(head, Load(head) + sum[h]);
      }
    }
  }
  const float share = 1.0f / static_cast<float>(rows);
  for (int i = 0; i < width; ++i) mean[i] *= share;
  for (int h = 0; h < kPoolingHeads; ++h) {
    const float inverse = 1.0f / total[h];
    for (int i = 0; i < width; ++i) heads[h * width + i] *= inverse;
  }
}

void Transform(float* x, int rows, int width, const PackedPooledBlock& block, const float* set) {
  float u[kTileRows * kMaxWidth], hidden[kTileRows * 2 * kMaxWidth];
  const int inner = 2 * width;
  for (int i = 0; i < kTileRows * width; ++i) u[i] = 0.0f;
  for (int row = 0; row < rows; row += kTileRows) {
    const int count = rows - row < kTileRows ? rows - row : kTileRows;
    float* tile = x + static_cast<long>(row) * width;
    for (int r = 0; r < count; ++r) NormRow(tile + r * width, width, block.norm, u + r * width);
    for (int column = 0; column < inner; column += kTileColumns) {
      Lanes sum[kTileRows][kTileVectors];
      Tile(u, width, block.point.weights + column, inner, set + column, sum);
      for (int r = 0; r < kTileRows; ++r)
        for (int c = 0; c < kTileVectors; ++c) Store(hidden + r * inner + column + c * kLanes, Gelu(sum[r][c]));
    }
    int column = 0;
    for (; column + kTileColumns <= width; column += kTileColumns) {
      Lanes sum[kTileRows][kTileVectors];
      Tile(hidden, inner, block.output.weights + column, width, block.output.bias + column, sum);
      for (int r = 0; r < count; ++r)
        for (int c = 0; c < kTileVectors; ++c) {
          float* value = tile + r * width + column + c * kLanes;
          Store(value, Load(value) + sum[r][c]);
        }
    }
    for (; column < width; column += kLanes)
      for (int r = 0; r < count; ++r) {
        Lanes sum = Load(block.output.bias + column);
        for (int k = 0; k < inner; ++k) sum += hidden[r * inner + k] * Load(block.output.weights + k * width + column);
        float* value = tile + r * width + column;
        Store(value, Load(value) + sum);
      }
  }
}

void Normalize(float* x, int rows, int width, PackedNorm norm) {
  for (int r = 0; r < rows; ++r)
    NormRow(x + static_cast<long>(r) * width, width, norm, x + static_cast<long>(r) * width);
}

void Project(const float* x, int rows, int width, const PackedNorm* norm, const float* w, float bias, float* out) {
  float u[kMaxWidth];
  for (int r = 0; r < rows; ++r) {
    const float* row = x + static_cast<long>(r) * width;
    if (norm != nullptr) {
      NormRow(row, width, *norm, u);
      row = u;
    }
    Lanes sum = {};
    for (int i = 0; i < width; i += kLanes) sum += Load(row + i) * Load(w + i);
    out[r] = Sum(sum) + bias;
  }
}

void AddInputs(const float* context, int rows, int width, const float* constant, const float* const* inputs,
               const float* w, int count, float* x) {
  for (int r = 0; r < rows; ++r)
    for (int i = 0; i < width; i += kLanes) {
      Lanes sum = Load(context + static_cast<long>(r) * width + i) + Load(constant + i);
      for (int k = 0; k < count; ++k) sum += inputs[k][r] * Load(w + k * width + i);
      Store(x + static_cast<long>(r) * width + i, sum);
    }
}

template <class Function>
inline void Each(float* values, std::size_t count, const Function& function) {
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) Store(values + i, function(Load(values + i)));
  for (; i < count; ++i) values[i] = function(Lanes{} + values[i])[0];
}

void Confidence(float* values, std::size_t count) {
  Each(values, count, [](Lanes x) { return 2.0f * Sigmoid(x) - 1.0f; });
}

void SigmoidOf(float* values, std::size_t count) {
  Each(values, count, [](Lanes x) { return Sigmoid(x); });
}

}  // namespace

extern const Kernels kKernels;
const Kernels kKernels = {DIFFSAC_KERNELS_NAME, Linear,   Pool, Transform, Normalize, Project, AddInputs,
                          Confidence,           SigmoidOf};

}  // namespace DIFFSAC_KERNELS
}  // namespace diffsac
