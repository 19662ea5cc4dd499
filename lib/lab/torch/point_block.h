#pragma once

#include <torch/nn/module.h>
#include <torch/types.h>

#include <memory>

#include "diffsac/core/random.h"
#include "lab/torch/denoiser.h"

namespace diffsac {

/// A residual layer over sets of points, equivariant to their order.
class PointBlock : public torch::nn::Module {
 public:
  /// x: [S, N, W]; mask: [S, N] bool, false for padding, or undefined. What stands in the padding does not matter to
  /// the others. Returns [S, N, W].
  virtual torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& mask) = 0;
};

/// kind: kPooled, kMlp or kDgcnn, whose `neighbors` they are.
std::shared_ptr<PointBlock> MakePointBlock(DenoiserKind kind, std::int64_t width, std::int64_t neighbors, Rng rng);

}  // namespace diffsac
