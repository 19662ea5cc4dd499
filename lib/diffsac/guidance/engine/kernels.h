#pragma once

#include <cstddef>

namespace diffsac {

/// A linear layer as the kernels read it: y = x W + b with W [in, out], rows of `out` values, which are a multiple of
/// kKernelLanes.
struct PackedLinear {
  const float* weights;
  const float* bias;
};

/// Layer normalisation (ε = 1e-5) of `width` channels.
struct PackedNorm {
  const float* scale;
  const float* shift;
};

/// Widths are multiples of this.
inline constexpr int kKernelLanes = 16;
inline constexpr int kPoolingHeads = 4;

/// A pooled block (lab/torch/pooled_block.h) of width W.
struct PackedPooledBlock {
  PackedNorm norm;
  const float* attention;       ///< kPoolingHeads rows of W
  const float* attention_bias;  ///< kPoolingHeads
  PackedLinear set;             ///< (2 + kPoolingHeads) W → 2 W
  PackedLinear point;           ///< W → 2 W
  PackedLinear output;          ///< 2 W → W
};

/// What a pooled network is made of, over rows of floats (row-major, any alignment), compiled for several processors:
/// vector registers of 4, 8 or 16 floats, with fused multiply-add where there is. Results agree to rounding.
struct Kernels {
  const char* name;  ///< "avx512", "avx2", "baseline"

  /// y[rows, out] = x[rows, in] W + b.
  void (*linear)(const float* x, int rows, int in, int out, PackedLinear layer, float* y);
  /// Mean, maximum and kPoolingHeads softmax-weighted means over the rows of the block's norm(x): (2 + kPoolingHeads)·W
  /// values.
  void (*pool)(const float* x, int rows, int width, const PackedPooledBlock& block, float* pooled);
  /// x += output(gelu(point(norm(x)) + set)), set[2 W] being what comes of the pooled values, the block's biases added.
  void (*transform)(float* x, int rows, int width, const PackedPooledBlock& block, const float* set);
  /// x = norm(x).
  void (*normalize)(float* x, int rows, int width, PackedNorm norm);
  /// out[row] = w · norm(x[row]) + bias; without a norm (null) w · x[row] + bias.
  void (*project)(const float* x, int rows, int width, const PackedNorm* norm, const float* w, float bias, float* out);
  /// x[row] = context[row] + constant + Σ_i inputs[i][row] w[i], w: `count` rows of W.
  void (*add_inputs)(const float* context, int rows, int width, const float* constant, const float* const* inputs,
                     const float* w, int count, float* x);
  /// In place: logit → 2 sigmoid − 1, the expected label; and logit → sigmoid.
  void (*confidence)(float* values, std::size_t count);
  void (*sigmoid)(float* values, std::size_t count);
};

/// Those of this machine's processor, chosen once.
const Kernels& BestKernels();

/// All that this build has and this machine can run, the best first; for tests and benchmarks.
struct KernelList {
  const Kernels* all[3];
  int count;
};
KernelList AvailableKernels();

}  // namespace diffsac
