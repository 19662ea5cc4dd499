#pragma once

#include <torch/nn/module.h>
#include <torch/types.h>

#include <memory>

#include "diffsac/core/random.h"
#include "diffsac/guidance/engine/network_options.h"

namespace diffsac {

/// A residual layer over sets of points, equivariant to their order.
class PointBlock : public torch::nn::Module {
 public:
  /// x: [S, N, W]; mask: [S, N] bool, false for padding, or undefined. What stands in the padding does not matter to
  /// the others. Returns [S, N, W].
  virtual torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& mask) = 0;
};

/// Of the options' kind and width. `mlp`, "MLPs" of the paper's ablation (e), is a layer of each point by itself:
/// x + B gelu(A norm(x)), A to twice the width. The others have files of their own.
std::shared_ptr<PointBlock> MakePointBlock(const DenoiserOptions& options, Rng rng);

}  // namespace diffsac
