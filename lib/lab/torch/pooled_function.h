#pragma once

#include <torch/types.h>

namespace diffsac {

/// The parameters of a PooledBlock, all of single precision.
struct PooledWeights {
  torch::Tensor gain, shift;                ///< [W], of the layer norm
  torch::Tensor attention, attention_bias;  ///< [4, W], [4]
  torch::Tensor set, set_bias;              ///< [2 W, 6 W], [2 W]
  torch::Tensor point, point_bias;          ///< [2 W, W], [2 W]
  torch::Tensor output, output_bias;        ///< [W, 2 W], [W]
};

/// Whether PooledForward computes this: a training step in single precision on a CPU, W a multiple of 8.
bool HasPooledForward(const torch::Tensor& x);

/// PooledBlock::Forward with its own gradient: a few sets at a time pass through the whole block while they are in the
/// cache, instead of all sets through one operation after another. Equal to the block's own operations up to rounding
/// (test), and the same for any number of threads. x: [S, N, W]; mask: [S, N] bool or undefined.
torch::Tensor PooledForward(const torch::Tensor& x, const torch::Tensor& mask, const PooledWeights& weights);

}  // namespace diffsac
